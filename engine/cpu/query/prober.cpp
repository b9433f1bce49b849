#include "cpu/query/prober.hpp"

#include <algorithm>

#include "input/implied_wants.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t most_together = 64;  // probes that share a window

}  // namespace

Prober::Prober(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels)
    : seeds_(seeds),
      builder_(seeds, hierarchy, kernels),
      star_(make_star(kernels.name, seeds, hierarchy)),
      writer_(seeds) {}

void Prober::begin_job(const Job& job, const StarKernels& kernels, ResultBuilder& out) {
    builder_.begin_job(*job.domain);
    star_->begin_job(*job.domain);
    writer_.begin_job(job, kernels, out);
    measure_ = needs_geometry(job.options.want);
}

// Returns how many of the probes lie near enough to the first to look around together: in a box no longer than what a
// vertex reaches.
std::size_t Prober::look_around(std::span<const Probe> probes) {
    const double longest = star_->usual_reach();
    Box box{probes[0].place.at, probes[0].place.at};
    double lightest = probes[0].weight;
    std::size_t count = 1;
    for (; count < std::min(probes.size(), most_together); ++count) {
        Box larger = box;
        double side = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            larger.lower[k] = std::min(box.lower[k], probes[count].place.at[k]);
            larger.upper[k] = std::max(box.upper[k], probes[count].place.at[k]);
            side = std::max(side, larger.upper[k] - larger.lower[k]);
        }
        if (side > longest) break;
        box = larger;
        lightest = std::min(lightest, probes[count].weight);
    }
    star_->look_around(box, lightest);
    return count;
}

void Prober::run(std::span<const Probe> probes, std::span<const std::int32_t> cells, std::size_t near,
                 std::span<std::int32_t> duplicate_of) {
    const bool walk = seeds_.size() > 0;
    if (walk) star_->begin_probes(near, measure_);
    writer_.begin_stretch();
    for (std::size_t begin = 0, end = 0; begin < probes.size(); begin = end) {
        end = walk ? begin + look_around(probes.subspan(begin)) : probes.size();
        for (std::size_t k = begin; k < end; ++k) {
            const auto output = static_cast<std::size_t>(cells[k]);
            if (!walk || !star_->build(probes[k]) || !writer_.write(output, probes[k], *star_))
                clip(probes[k], cells[k], duplicate_of);
        }
    }
    writer_.end_block(cells);
}

void Prober::clip(const Probe& probe, std::int32_t cell, std::span<std::int32_t> duplicate_of) {
    const auto output = static_cast<std::size_t>(cell);
    Cell& clipped = builder_.build(probe);
    const std::int32_t there = builder_.coincident();
    const double weight = there < 0 || seeds_.weights.empty() ? 0 : seeds_.weights[static_cast<std::size_t>(there)];
    if (there >= 0 && weight == probe.weight) {
        duplicate_of[output] = seeds_.input[static_cast<std::size_t>(there)];
        writer_.leave_out();
    } else if (there >= 0 && weight > probe.weight) {
        writer_.write_none(output, CellStatus::empty);
    } else {
        writer_.write(output, probe, measure_ ? builder_.again(faces_) : clipped);
    }
}

}  // namespace votess::cpu

#include "query/prober.hpp"

#include <algorithm>

#include "core/box.hpp"
#include "core/progress.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t max_together = 64;     // probes that share a window
constexpr std::size_t probes_per_look = 16;  // after which the user may stop

}  // namespace

Prober::Prober(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels)
    : seeds_(seeds), builder_(seeds, hierarchy, kernels), star_(make_star(kernels.name, seeds, hierarchy)) {}

void Prober::begin_job(const Domain& domain, Star::Keep keep) {
    builder_.begin_job(domain);
    star_->begin_job(domain);
    keep_ = keep;
}

// Returns how many probes share one window. They lie in a box near the first, no longer than the reach of a vertex.
std::size_t Prober::look_around(std::span<const Probe> probes) {
    const double longest = star_->typical_reach();
    Box box{probes[0].place.at, probes[0].place.at};
    double lightest = probes[0].weight;
    std::size_t count = 1;
    for (; count < std::min(probes.size(), max_together); ++count) {
        Box larger = box;
        include(larger, probes[count].place.at);
        double side = 0;
        for (std::size_t k = 0; k < 3; ++k) side = std::max(side, larger.upper[k] - larger.lower[k]);
        if (side > longest) break;
        box = larger;
        lightest = std::min(lightest, probes[count].weight);
    }
    star_->look_around(box, lightest);
    return count;
}

void Prober::run(std::span<const Probe> probes, std::size_t near, ProbeSink& sink) {
    const bool walk = seeds_.size() > 0;
    if (walk) star_->begin_probes(near, keep_);
    for (std::size_t begin = 0, end = 0; begin < probes.size(); begin = end) {
        end = walk ? begin + look_around(probes.subspan(begin)) : probes.size();
        for (std::size_t k = begin; k < end; ++k) {
            if (k % probes_per_look == 0) check_stop();
            if (!walk || !star_->build(probes[k]) || !sink.take(k, *star_)) clip(probes[k], k, sink);
        }
    }
}

void Prober::clip(const Probe& probe, std::size_t k, ProbeSink& sink) {
    Cell& cell = builder_.build(probe);
    const std::int32_t there = builder_.coincident();
    const auto seed = static_cast<std::size_t>(there);
    const bool placed = keep_ == Star::Keep::places;
    if (there < 0 || (!seeds_.weights.empty() && seeds_.weights[seed] < probe.weight)) {
        sink.take(k, placed ? builder_.rebuild(faces_) : cell);
    } else if (sink.taken(k, seed)) {
        Cell& of_seed = builder_.build(seed);
        sink.take_seed(k, seed, placed ? builder_.rebuild(faces_) : of_seed);
    }
}

}  // namespace votess::cpu

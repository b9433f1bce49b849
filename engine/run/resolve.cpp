// Plan::resolve(): makes the cells that a recorded frame could not certify, exactly, on the CPU.
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <vector>

#include "distributed/blocks/local_block.hpp"
#include "domain/near_places.hpp"
#include "gpu/frames/frame.hpp"
#include "input/domain_of_result.hpp"
#include "input/seeds.hpp"
#include "input/settle.hpp"

namespace votess::vulkan {
namespace {

using detail::is_unresolved;

// Returns whether the CPU uses a seed. It skips seeds that the frame skipped, and seeds without a cell, which are not
// neighbors of any.
bool is_there(std::uint32_t status) {
    return status == static_cast<std::uint32_t>(CellStatus::certified) || is_unresolved(status);
}

// Makes few cells from the seeds near them. Such a cell is right when no other seed can reach it: its neighbors among a
// set that holds all seeds that may cut it are its neighbors among all.
template <class Real>
class Resolver {
public:
    Resolver(const PlanOptions& plan, std::span<const Real> seeds, std::span<const Real> weights,
             std::span<const Cell> cells, const ResolveOptions& how)
        : seeds_(seeds), weights_(weights), cells_(cells), stride_(plan.stride), weight_options_(plan.weights) {
        detail::check_domain(plan, {.box = how.box, .cell = how.cell});
        check_count(seeds.size(), 3, stride_, "seeds");
        if (plan.weights)
            check_count(weights.size(), plan.weights->first + std::size_t{1}, plan.weights->stride, "weights");
        else if (!weights.empty())
            refuse("weights are given, but the plan has none");
        Options options;
        if (plan.cell)
            options.cell = how.cell.value_or(*plan.cell);
        else
            options.box = how.box.value_or(plan.box);
        options.list_walls = plan.list_walls;
        options.periodic = plan.periodic;
        options.walls = plan.walls;
        if (!plan.walls.empty()) options.outside = Outside::drop;  // seeds that the frame was not sure of
        options.threads = how.threads;
        options.want = {.neighbors = true, .volumes = true, .centroids = true, .areas = plan.areas};
        run_ = settle(options);
    }

    Resolved resolve() {
        std::vector<Open> open;
        std::size_t count = 0;
        double heaviest = -std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            if (is_there(cells_[i].status)) {
                ++count;
                heaviest = std::max(heaviest, weight(i));
            }
            if (is_unresolved(cells_[i].status)) open.push_back({i, open.size(), 0});
        }
        made_.resize(open.size());
        const Job empty = make_job(run_);
        heaviest_ = heaviest * empty.scale * empty.scale;
        const double spacing = std::cbrt(empty.domain->volume / static_cast<double>(std::max<std::size_t>(count, 1)));
        for (Open& cell : open) cell.distance = first_spacings * spacing;
        // In the second round the distances are those that the cells need, which do not grow.
        for (int round = 0; round < 2 && !open.empty() && open.size() < count / min_seeds_a_cell; ++round) {
            NearPlaces near(*empty.domain, 0.5 * first_spacings * spacing);
            for (const Open& cell : open) near.add(place(cell.seed, empty.scale), cell.distance);
            if (near.share() > largest_share) break;
            open = clip(open, [&](std::size_t i) { return near.holds(place(i, empty.scale)); });
        }
        if (!open.empty()) {
            for (Open& cell : open) cell.distance = std::numeric_limits<double>::infinity();
            clip(open, [](std::size_t) { return true; });
        }
        return gather();
    }

private:
    static constexpr double first_spacings = 4;  // mean distances between seeds: more than most cells need
    static constexpr std::size_t min_seeds_a_cell = 1000;
    static constexpr double largest_share = 0.25;  // of the domain: beyond it sorting all is not much slower

    struct Open {
        std::size_t seed, number;  // of the frame; among the unresolved
        double distance;           // within which all seeds are used, times scale
    };
    struct Made {
        std::size_t run, cell;
    };

    [[nodiscard]] exact::Point place(std::size_t i, double scale) const {
        return {seeds_[i * stride_] * scale, seeds_[i * stride_ + 1] * scale, seeds_[i * stride_ + 2] * scale};
    }
    [[nodiscard]] double weight(std::size_t i) const {
        return weight_options_ ? weights_[weight_options_->first + i * weight_options_->stride] : 0;
    }
    void check_count(std::size_t numbers, std::size_t first, std::size_t stride, const char* of) const {
        if (!cells_.empty() && numbers < (cells_.size() - 1) * stride + first)
            refuse(std::to_string(numbers) + " numbers are too few for " + of + " of " + std::to_string(cells_.size()) +
                   " cells with a stride of " + std::to_string(stride));
    }
    void add(Seeds& to, std::size_t i) const {
        to.ids.push_back(static_cast<std::int64_t>(i));
        if (weight_options_) to.weights.push_back(weight(i));
        for (std::size_t k = 0; k < 3; ++k) to.points.push_back(seeds_[i * stride_ + k]);
    }

    // Makes the cells, in ascending order, from the chosen seeds. Returns the cells that other seeds may reach.
    std::vector<Open> clip(const std::vector<Open>& open, const auto& chosen) {
        blocks::Run& run = runs_.emplace_back();
        for (const Open& cell : open) add(run.seeds, cell.seed);
        std::size_t next = 0;
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            if (next < open.size() && open[next].seed == i)
                ++next;
            else if (is_there(cells_[i].status) && chosen(i))
                add(run.seeds, i);
        }
        run.clip(run_, open.size());
        std::vector<Open> rest;
        for (std::size_t k = 0; k < open.size(); ++k) {
            const double reach = run.reach_of(k, heaviest_);
            // A seed without a cell among these has none among all.
            if (reach <= open[k].distance || run.result.status[k] != CellStatus::certified)
                made_[open[k].number] = {runs_.size() - 1, k};
            else
                rest.push_back({open[k].seed, open[k].number, reach});
        }
        return rest;
    }

    [[nodiscard]] Resolved gather() const {
        Resolved out;
        out.indptr.push_back(0);
        std::vector<std::vector<double>> wrapped;
        for (const blocks::Run& run : runs_) move_into_domain(run.job, wrapped.emplace_back(run.seeds.points));
        for (const Made& made : made_) {
            const blocks::Run& run = runs_[made.run];
            const votess::detail::Result& result = run.result;
            const std::size_t i = made.cell;
            const auto begin = static_cast<std::size_t>(result.indptr[i]);
            const auto end = static_cast<std::size_t>(result.indptr[i + 1]);
            out.cells.push_back(static_cast<std::uint32_t>(run.seeds.ids[i]));
            out.status.push_back(result.status[i]);
            for (std::size_t e = begin; e < end; ++e) {
                const std::int32_t id = result.indices[e];
                out.indices.push_back(id < 0 ? id
                                             : static_cast<std::int32_t>(run.seeds.ids[static_cast<std::size_t>(id)]));
            }
            if (!result.shifts.empty())
                out.shifts.insert(out.shifts.end(), result.shifts.begin() + 3 * begin, result.shifts.begin() + 3 * end);
            if (!result.face_areas.empty())
                out.areas.insert(out.areas.end(), result.face_areas.begin() + begin, result.face_areas.begin() + end);
            out.indptr.push_back(static_cast<std::int64_t>(out.indices.size()));
            out.volumes.push_back(result.volumes[i]);
            for (std::size_t k = 3 * i; k < 3 * i + 3; ++k)
                out.centroids.push_back(result.centroids[k] + (run.seeds.points[k] - wrapped[made.run][k]));
        }
        return out;
    }

    std::span<const Real> seeds_, weights_;
    std::span<const Cell> cells_;
    std::size_t stride_;
    std::optional<WeightOptions> weight_options_;
    double heaviest_ = 0;  // largest weight of a seed in use, times scale squared
    Settled run_;
    std::deque<blocks::Run> runs_;
    std::vector<Made> made_;  // in the order of the unresolved
};

}  // namespace

Resolved Plan::resolve(std::span<const float> seeds, std::span<const Cell> cells, const ResolveOptions& options) const {
    return resolve(seeds, {}, cells, options);
}

Resolved Plan::resolve(std::span<const double> seeds, std::span<const Cell> cells,
                       const ResolveOptions& options) const {
    return resolve(seeds, {}, cells, options);
}

Resolved Plan::resolve(std::span<const float> seeds, std::span<const float> weights, std::span<const Cell> cells,
                       const ResolveOptions& options) const {
    return Resolver<float>(state_->options, seeds, weights, cells, options).resolve();
}

Resolved Plan::resolve(std::span<const double> seeds, std::span<const double> weights, std::span<const Cell> cells,
                       const ResolveOptions& options) const {
    return Resolver<double>(state_->options, seeds, weights, cells, options).resolve();
}

}  // namespace votess::vulkan

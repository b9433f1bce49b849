// Plan::resolve(): the cells that a recorded frame could not certify, by the exact clipper.
#include <algorithm>
#include <limits>
#include <numeric>

#include "cpu/cpu_clipper.hpp"
#include "gpu/frame.hpp"
#include "input/options.hpp"

namespace votess::vulkan {
namespace {

bool is_unresolved(std::uint32_t status) {
    switch (static_cast<CellStatus>(status)) {
        case CellStatus::certified:
        case CellStatus::duplicate:
        case CellStatus::outside:
            return false;
        default:
            return true;
    }
}

// Some cells of a job; the others stay empty.
votess::detail::Result clip_some(const Job& job, std::span<const std::int32_t> cells) {
    cpu::CpuClipper clipper;
    ResultBuilder builder;
    votess::detail::Result result;
    clipper.begin(job);
    builder.begin(job, clipper.pool());
    std::ranges::fill(builder.volumes(), 0);
    std::ranges::fill(builder.centroids(), std::numeric_limits<double>::quiet_NaN());
    clipper.clip(cells, builder, {0, 1});
    clipper.set_empty(builder);
    builder.set_duplicates(clipper.duplicate_of(), clipper.pool());
    builder.finish(result, clipper.pool());
    return result;
}

template <class Real>
Resolved resolve_cells(const PlanOptions& plan, std::span<const Real> seeds, std::span<const Cell> cells,
                       const ResolveOptions& how) {
    const std::size_t count = cells.size(), stride = plan.stride;
    if (count > 0 && seeds.size() < (count - 1) * stride + 3)
        throw Error(ErrorCode::invalid_argument, std::to_string(seeds.size()) + " numbers are too few for " +
                                                     std::to_string(count) + " seeds with a stride of " +
                                                     std::to_string(stride));
    // Seeds that the frame has left out are not there for the CPU either; the others keep their order.
    std::vector<std::int32_t> kept, unresolved;
    std::vector<double> points;
    for (std::size_t i = 0; i < count; ++i) {
        if (cells[i].status == static_cast<std::uint32_t>(CellStatus::outside)) continue;
        if (is_unresolved(cells[i].status)) unresolved.push_back(static_cast<std::int32_t>(kept.size()));
        kept.push_back(static_cast<std::int32_t>(i));
        for (std::size_t k = 0; k < 3; ++k) points.push_back(seeds[i * stride + k]);
    }
    Resolved out;
    out.indptr.push_back(0);
    if (unresolved.empty()) return out;

    Options options;
    options.box = how.box.value_or(plan.box);
    options.list_walls = plan.list_walls;
    options.periodic = plan.periodic;
    options.threads = how.threads;
    options.want = {.neighbors = true, .volumes = true, .centroids = true};
    const votess::detail::Result result = clip_some(validate({points, {}}, options), unresolved);
    for (const std::int32_t cell : unresolved) {
        const auto i = static_cast<std::size_t>(cell);
        out.cells.push_back(static_cast<std::uint32_t>(kept[i]));
        out.status.push_back(result.status[i]);
        for (std::int64_t entry = result.indptr[i]; entry < result.indptr[i + 1]; ++entry) {
            const std::int32_t id = result.indices[static_cast<std::size_t>(entry)];
            out.indices.push_back(id < 0 ? id : kept[static_cast<std::size_t>(id)]);
        }
        if (!result.shifts.empty())
            out.shifts.insert(out.shifts.end(), result.shifts.begin() + 3 * result.indptr[i],
                              result.shifts.begin() + 3 * result.indptr[i + 1]);
        out.indptr.push_back(static_cast<std::int64_t>(out.indices.size()));
        out.volumes.push_back(result.volumes[i]);
        for (std::size_t k = 0; k < 3; ++k) out.centroids.push_back(result.centroids[3 * i + k]);
    }
    return out;
}

}  // namespace

Resolved Plan::resolve(std::span<const float> seeds, std::span<const Cell> cells, const ResolveOptions& options) const {
    return resolve_cells(state_->options, seeds, cells, options);
}

Resolved Plan::resolve(std::span<const double> seeds, std::span<const Cell> cells,
                       const ResolveOptions& options) const {
    return resolve_cells(state_->options, seeds, cells, options);
}

}  // namespace votess::vulkan

#include "distributed/blocks/blocks.hpp"

#include <algorithm>
#include <cmath>

#include "core/box.hpp"
#include "core/errors.hpp"
#include "distributed/blocks/partition.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "plane/sheet.hpp"
#include "query/locator.hpp"
#include "result/arrays.hpp"
#include "unbounded/endless_box.hpp"

namespace votess {
namespace detail {

struct BlockDomainState {
    Settled whole;
    std::optional<Sheet> sheet;
    Settled in_space, of_blocks;
    std::optional<EndlessSides> ends;
    Job job;  // of blocks, without seeds
    std::optional<blocks::Partition> partition;
};

}  // namespace detail

namespace {

template <class Work>
auto with_memory(const Work& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, "out of memory: use more blocks, each with fewer seeds");
    }
}

void check_for_blocks(const Settled& run) {
    if (run.device != "cpu" && run.device != "auto")
        throw Error(ErrorCode::unsupported,
                    option("device") + " = " + run.device + ": blocks find their cells on the CPU, give cpu or auto");
    if (run.want.vertices || run.want.faces)
        throw Error(ErrorCode::unsupported,
                    "vertices and faces are not available across blocks: leave them out of " + option("want"));
    if (run.min_face != 0 || run.min_area != 0)
        throw Error(ErrorCode::unsupported,
                    option("min_face") + " and " + option("min_area") + " need the faces of all cells: leave them out");
    if (run.subset)
        throw Error(ErrorCode::unsupported,
                    "cells of some seeds are not available across blocks: leave out " + option("only"));
    if (run.region.mesh)
        throw Error(ErrorCode::unsupported, "cells are not cut by a mesh across blocks: leave out " + option("mesh") +
                                                ", or tessellate in one memory");
    if (run.duplicates == Duplicates::error)
        throw Error(ErrorCode::unsupported,
                    option("duplicates") + " = error is not available across blocks: check the statuses");
}

}  // namespace

BlockDomain::BlockDomain(Settled whole, const Box& bounds, std::uint64_t seeds)
    : state_(std::make_shared<detail::BlockDomainState>()) {
    check_for_blocks(whole);
    whole.weights = {};
    whole.device = "cpu";
    if (whole.region.planar) state_->sheet.emplace(bounds, seeds, whole);
    Settled& in_space = state_->in_space = state_->sheet ? state_->sheet->in_space() : whole;
    Settled& of_blocks = state_->of_blocks = in_space;
    state_->ends.emplace(in_space.region);
    if (endless()) {
        const std::vector<double> corners{bounds.lower[0], bounds.lower[1], bounds.lower[2],
                                          bounds.upper[0], bounds.upper[1], bounds.upper[2]};
        end_near(of_blocks.region, {corners, {}});
        of_blocks.list_walls = of_blocks.want.neighbors = true;
    } else if (!whole.region.cell) {
        Box box = box_of(of_blocks.region, bounds, seeds);
        in_space.region.box = of_blocks.region.box = box;
        if (whole.region.planar) box.lower[2] = box.upper[2] = 0;
        whole.region.box = box;
    }
    state_->job = make_job(of_blocks);
    state_->whole = std::move(whole);
}

const Settled& BlockDomain::whole() const noexcept {
    return state_->whole;
}

const Settled& BlockDomain::in_space() const noexcept {
    return state_->in_space;
}

const Settled& BlockDomain::of_blocks() const noexcept {
    return state_->of_blocks;
}

bool BlockDomain::endless() const noexcept {
    return state_->ends->any();
}

bool BlockDomain::is_end(std::int32_t id) const noexcept {
    return endless() && state_->ends->has(id);
}

void BlockDomain::complete(detail::Result& cells) const {
    if (endless()) detail::keep_wanted(cells, state_->in_space.want, state_->in_space.list_walls);
    if (state_->sheet) state_->sheet->flatten(cells);
}

double BlockDomain::volume(std::span<const double> seed) const {
    if (endless()) return infinity;
    const std::vector<double> copy(seed.begin(), seed.end());
    Settled run = state_->of_blocks;
    run.points = {copy, {}};
    return make_job(std::move(run)).box_volume;
}

std::vector<CellStatus> BlockDomain::check(std::span<const double> points, const Weights& weights,
                                           std::uint64_t first) const {
    return with_memory([&] {
        const std::vector<double> copy(points.begin(), points.end());
        Settled run = state_->of_blocks;
        run.points = {copy, {}, first};
        run.weights = weights;
        Job job = make_job(std::move(run));
        job.outside.resize(copy.size() / 3, CellStatus::certified);
        return std::move(job.outside);
    });
}

std::vector<double> BlockDomain::places(std::span<const double> points) const {
    std::vector<double> places(points.size());
    for (std::size_t i = 0; i < points.size() / 3; ++i) {
        const auto place = cpu::place_in(*state_->job.domain, point_of(points, i, state_->job.scale));
        if (!place) refuse("point " + std::to_string(i) + " lies more than 500 million periods away from the box");
        for (std::size_t k = 0; k < 3; ++k) places[3 * i + k] = place->at[k];
    }
    return places;
}

void BlockDomain::split(std::span<const double> sample, std::size_t blocks) {
    if (blocks == 0) refuse("a run needs one block or more");
    std::vector<exact::Point> points(sample.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i] = point_of(sample, i);
        if (!std::ranges::all_of(points[i], [](double x) { return std::isfinite(x); }))
            refuse("place " + std::to_string(i) + " of the sample is not finite");
    }
    state_->partition.emplace(std::move(points), blocks);
}

std::vector<std::uint32_t> BlockDomain::blocks_of(std::span<const double> places) const {
    if (!state_->partition) throw Error(ErrorCode::invalid_use, "blocks_of() before split()");
    std::vector<std::uint32_t> blocks(places.size() / 3);
    for (std::size_t i = 0; i < blocks.size(); ++i)
        blocks[i] = static_cast<std::uint32_t>(state_->partition->block_of(point_of(places, i)));
    return blocks;
}

CheckedRun checked_run(const BlockDomain& domain, std::uint64_t seeds, double volume) {
    CheckedRun run{domain.of_blocks(), seeds, volume};
    run.settled.list_walls = domain.whole().list_walls;
    run.planar = domain.whole().region.planar;
    run.ends = EndlessSides(domain.in_space().region);
    return run;
}

}  // namespace votess

#include "distributed/blocks/blocks.hpp"

#include <algorithm>
#include <cmath>

#include "distributed/blocks/messages.hpp"
#include "distributed/blocks/partition.hpp"
#include "input/implied_wants.hpp"
#include "input/options.hpp"
#include "query/locator.hpp"

namespace votess {
namespace detail {

struct BlockDomainState {
    Options options;
    Job job;  // without seeds
    std::optional<blocks::Partition> partition;
};

struct BlockState {
    BlockState(const Options& options, Seeds own) : block(options, std::move(own)) {}
    blocks::LocalBlock block;
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

Options settled(Options options, const Box& bounds, std::uint64_t seeds) {
    if (options.device != "cpu" && options.device != "auto")
        throw Error(ErrorCode::unsupported,
                    "Options::device = " + options.device + ": blocks find their cells on the CPU, give cpu or auto");
    const Want want = with_implied(options);
    if (want.vertices || want.faces)
        throw Error(ErrorCode::unsupported,
                    "vertices and faces are not available across blocks: leave them out of Options::want");
    if (options.min_face != 0 || options.min_area != 0)
        throw Error(ErrorCode::unsupported,
                    "Options::min_face and Options::min_area need the faces of all cells: leave them out");
    if (options.only)
        throw Error(ErrorCode::unsupported,
                    "cells of some seeds are not available across blocks: leave out Options::only");
    if (options.duplicates == Duplicates::error)
        throw Error(ErrorCode::unsupported,
                    "Options::duplicates = error is not available across blocks: check the statuses");
    options.weights = options.radii = {};
    options.device = "cpu";
    check_options(options);
    if (!options.cell) options.box = box_of(options, bounds, seeds);
    return options;
}

exact::Point point_of(std::span<const double> points, std::size_t i, double scale) {
    return {points[3 * i] * scale, points[3 * i + 1] * scale, points[3 * i + 2] * scale};
}

}  // namespace

BlockDomain::BlockDomain(const Options& options, const Box& bounds, std::uint64_t seeds)
    : state_(std::make_shared<detail::BlockDomainState>()) {
    state_->options = settled(options, bounds, seeds);
    state_->job = validate({}, state_->options);
}

const Options& BlockDomain::options() const noexcept {
    return state_->options;
}

double BlockDomain::volume(std::span<const double> seed) const {
    const std::vector<double> copy(seed.begin(), seed.end());
    return validate({copy, {}}, state_->options).box_volume;
}

std::vector<CellStatus> BlockDomain::check(std::span<const double> points, std::span<const double> weights,
                                           std::span<const double> radii, std::uint64_t first) const {
    Options options = state_->options;
    options.weights = weights;
    options.radii = radii;
    return with_memory([&] {
        const std::vector<double> copy(points.begin(), points.end());
        Job job = validate({copy, {}, first}, options);
        job.outside.resize(copy.size() / 3, CellStatus::certified);
        return std::move(job.outside);
    });
}

std::vector<double> BlockDomain::places(std::span<const double> points) const {
    std::vector<double> places(points.size());
    for (std::size_t i = 0; i < points.size() / 3; ++i) {
        const auto place = cpu::place_in(*state_->job.domain, point_of(points, i, state_->job.scale));
        if (!place)
            throw Error(ErrorCode::invalid_argument,
                        "point " + std::to_string(i) + " lies more than 500 million periods away from the box");
        for (std::size_t k = 0; k < 3; ++k) places[3 * i + k] = place->at[k];
    }
    return places;
}

void BlockDomain::split(std::span<const double> sample, std::size_t blocks) {
    if (blocks == 0) throw Error(ErrorCode::invalid_argument, "a run needs one block or more");
    std::vector<exact::Point> points(sample.size() / 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i] = point_of(sample, i, 1);
        if (!std::ranges::all_of(points[i], [](double x) { return std::isfinite(x); }))
            throw Error(ErrorCode::invalid_argument, "place " + std::to_string(i) + " of the sample is not finite");
    }
    state_->partition.emplace(std::move(points), blocks);
}

std::vector<std::uint32_t> BlockDomain::blocks_of(std::span<const double> places) const {
    if (!state_->partition) throw Error(ErrorCode::invalid_use, "blocks_of() before split()");
    std::vector<std::uint32_t> blocks(places.size() / 3);
    for (std::size_t i = 0; i < blocks.size(); ++i)
        blocks[i] = static_cast<std::uint32_t>(state_->partition->block_of(point_of(places, i, 1)));
    return blocks;
}

Block::Block(const BlockDomain& domain, std::span<const std::int64_t> ids, std::span<const double> points,
             std::span<const double> weights, std::span<const std::int32_t> tags) {
    const std::size_t count = ids.size();
    if (points.size() != 3 * count || (!weights.empty() && weights.size() != count) ||
        (!tags.empty() && tags.size() != count))
        throw Error(ErrorCode::invalid_argument, "ids, points, weights and tags of a block differ in number: give " +
                                                     std::to_string(count) +
                                                     " of each, and three times as many coordinates");
    state_ = with_memory([&] {
        Seeds own{{ids.begin(), ids.end()},
                  {points.begin(), points.end()},
                  {weights.begin(), weights.end()},
                  {tags.begin(), tags.end()}};
        for (std::size_t i = 0; i < count; ++i)
            if (own.ids[i] < 0 || (i > 0 && own.ids[i] <= own.ids[i - 1]))
                throw Error(ErrorCode::invalid_argument, "ids of a block must ascend from 0 on: the one at " +
                                                             std::to_string(i) + " is " + std::to_string(own.ids[i]));
        own.tags.resize(count, 0);
        return std::make_unique<detail::BlockState>(domain.options(), std::move(own));
    });
}

Block::Block(Block&&) noexcept = default;
Block& Block::operator=(Block&&) noexcept = default;
Block::~Block() = default;

Message Block::outline() const {
    return with_memory([&] { return to_message(blocks::summary_of(state_->block.outline())); });
}

Message Block::halo_for(const Message& outline) const {
    return with_memory([&] {
        blocks::Outline other;
        from_message(outline, other);
        return to_message(state_->block.halo_for(other), state_->block.outline());
    });
}

void Block::clip(std::span<const Message> outlines, std::size_t own, std::span<const Message> halos) {
    if (halos.size() != outlines.size() || own >= outlines.size())
        throw Error(ErrorCode::invalid_argument,
                    "clip() of a block needs an outline and a halo of each block, but got " +
                        std::to_string(outlines.size()) + " and " + std::to_string(halos.size()) + ", for block " +
                        std::to_string(own));
    with_memory([&] {
        std::vector<blocks::Outline> others(outlines.size());
        Seeds all;
        for (std::size_t b = 0; b < outlines.size(); ++b) {
            if (b == own) continue;
            from_message(outlines[b], others[b]);
            Seeds halo;
            from_message(halos[b], halo, others[b]);
            all.add(halo);
        }
        state_->block.clip(std::move(others), own, std::move(all));
    });
}

Message Block::request_for(std::size_t block) const {
    return with_memory([&] { return to_message(state_->block.requests().at(block)); });
}

std::vector<Message> Block::reply(std::span<const Message> requests) const {
    return with_memory([&] {
        std::vector<blocks::Requests> all(requests.size());
        for (std::size_t b = 0; b < all.size(); ++b) from_message(requests[b], all[b]);
        std::vector<Message> replies;
        for (const Seeds& seeds : state_->block.reply(all)) replies.push_back(to_message(seeds));
        return replies;
    });
}

BlockCells Block::finish(std::span<const Message> replies) {
    return with_memory([&] {
        Seeds all;
        for (const Message& reply : replies) {
            Seeds seeds;
            from_message(reply, seeds);
            all.add(seeds);
        }
        return state_->block.finish(all);
    });
}

const BlockCounts& Block::counts() const noexcept {
    return state_->block.counts();
}

}  // namespace votess

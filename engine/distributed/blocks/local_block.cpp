#include "distributed/blocks/local_block.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/progress.hpp"
#include "input/options.hpp"
#include "query/locator.hpp"
#include "walk/star_bounds.hpp"

namespace votess::blocks {
namespace {

constexpr double reach_slack = 1 + 1e-6;  // of what is rounded

Options options_for(const Seeds& seeds, Options options) {
    options.weights = seeds.weights;
    options.radii = {};
    options.want.neighbors = true;
    options.min_face = options.min_area = 0;
    return options;
}

// The place of each id among all; they ascend up to `middle`, and from there on.
std::vector<std::int32_t> places_by_id(std::span<const std::int64_t> ids, std::size_t middle) {
    std::vector<std::int32_t> order(ids.size()), places(ids.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::inplace_merge(order, order.begin() + static_cast<std::ptrdiff_t>(middle), {},
                               [ids](std::int32_t i) { return ids[static_cast<std::size_t>(i)]; });
    for (std::size_t k = 0; k < order.size(); ++k)
        places[static_cast<std::size_t>(order[k])] = static_cast<std::int32_t>(k);
    return places;
}

}  // namespace

void Run::prepare(const Options& options) {
    job = validate({seeds.points, {}}, options_for(seeds, options));
    job.row_order = row_order;
    clipper.begin(job);
    Progress progress(options.progress);
    const Stoppable stoppable(progress);
    clipper.sort();
    clipper.build_search();
}

void Run::clip(const Options& options, std::size_t first) {
    row_order = places_by_id(seeds.ids, first);
    prepare(options);
    Progress progress(options.progress);
    Job of_first = job;
    of_first.points.f64 = of_first.points.f64.first(3 * first);
    of_first.options.weights = {};
    ResultBuilder builder;
    ThreadPool& pool = clipper.pool();
    builder.begin(of_first, pool);
    powers.assign(first, cpu::Star::min_power);
    clipper.clip_first(first, powers, builder, clipping);
    Progress::require(progress.going_on(clipping.end));
    const Stoppable stoppable(progress);
    clipper.set_empty(builder);
    const auto duplicate_of = clipper.duplicate_of();
    builder.set_duplicates(duplicate_of.first(std::min(first, duplicate_of.size())), pool);
    builder.finish(result, pool);
}

// It looks at all vertices of the cell: those that the cell did not find itself, a neighbor among the first ones found.
double Run::reach_of(std::size_t cell, double heaviest) const {
    double power = powers[cell];
    for (auto e = static_cast<std::size_t>(result.indptr[cell]); e < static_cast<std::size_t>(result.indptr[cell + 1]);
         ++e) {
        const std::int32_t neighbor = result.indices[e];
        if (neighbor >= 0 && static_cast<std::size_t>(neighbor) < powers.size())
            power = std::max(power, powers[static_cast<std::size_t>(neighbor)]);
    }
    const double weight = job.domain->weights.empty() ? 0 : job.domain->weights[cell];
    const double square = cpu::bounds::back(power, weight);
    return (std::sqrt(square) + std::sqrt(square + std::max(0.0, heaviest - weight))) * reach_slack;
}

LocalBlock::LocalBlock(const Options& options, Seeds own, std::optional<TiledSeeds> tiled)
    : options_(options),
      count_(own.size()),
      all_{.seeds = std::move(own), .row_order = {}, .job = {}, .clipper = {}, .powers = {}, .result = {}},
      job_(validate({all_.seeds.points, {}}, options_for(all_.seeds, options))),
      nearness_(*job_.domain) {
    places_.reserve(count_);
    for (std::size_t i = 0; i < count_; ++i) {
        exact::Point x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = all_.seeds.points[3 * i + k] * job_.scale;
        const auto place = cpu::place_in(*job_.domain, x);
        if (!place)
            throw Error(ErrorCode::invalid_argument, "seed " + std::to_string(all_.seeds.ids[i]) +
                                                         " lies more than 500 million periods away from the box");
        places_.push_back(place->at);
    }
    job_.points = {};
    all_.clipper.begin(job_);  // for its threads
    tiled_ = tiled ? std::move(*tiled) : tile_seeds(places_, job_.domain->weights, all_.clipper.pool());
}

LocalBlock::~LocalBlock() = default;

Seeds LocalBlock::layer_for(const Outline& other) const {
    Seeds layer;
    if (other.tiles.empty()) return layer;
    for (std::size_t t = 0; t < tiled_.outline.tiles.size(); ++t) {
        const Nearness::Layer of_tile = nearness_.layer_of(tiled_.outline.tiles[t], other.box);
        if (of_tile.by.empty()) continue;
        for (std::size_t k = tiled_.begin[t]; k < tiled_.begin[t + 1]; ++k)
            if (Nearness::holds(of_tile, places_[tiled_.order[k]])) layer.add(all_.seeds, tiled_.order[k]);
    }
    return layer;
}

void LocalBlock::clip(std::vector<Outline> others, std::size_t number, Seeds given) {
    outlines_ = std::move(others);
    number_ = number;
    counts_.given += given.size();
    all_.seeds.reserve(count_ + given.size());
    all_.seeds.add(given.sorted());
    given = {};
    all_.clip(options_, count_);
    positions_.assign(count_, -1);
    const auto& input = all_.clipper.seeds().input;
    for (std::size_t s = 0; s < input.size(); ++s)
        if (static_cast<std::size_t>(input[s]) < count_)
            positions_[static_cast<std::size_t>(input[s])] = static_cast<std::int32_t>(s);
    ask();
}

double LocalBlock::weight_of(std::size_t cell) const {
    return job_.domain->weights.empty() ? 0 : job_.domain->weights[cell];
}

// Bounds the reach of all cells, without a look at their neighbors.
double LocalBlock::longest_reach(double heaviest) const {
    if (all_.powers.empty()) return 0;
    const auto& weights = job_.domain->weights;
    const auto [lightest, own_heaviest] =
        weights.empty() ? std::pair(0.0, 0.0) : std::pair(std::ranges::min(weights), std::ranges::max(weights));
    const double square = cpu::bounds::back(std::ranges::max(all_.powers), own_heaviest);
    return (std::sqrt(square) + std::sqrt(square + std::max(0.0, heaviest - lightest))) * reach_slack;
}

bool LocalBlock::any_near(std::size_t tile, double reach) const {
    const Box& home = tiled_.outline.tiles[tile].box;
    bool any = false;
    for (std::size_t b = 0; b < outlines_.size() && !any; ++b)
        if (b != number_)
            outlines_[b].for_tiles([&](const Box& box) { return !any && nearness_.is_near(box, home, reach); },
                                   [&](std::size_t) { any = true; });
    return any;
}

std::vector<LocalBlock::Unknown> LocalBlock::unknown_near(std::size_t tile, double reach) const {
    std::vector<Unknown> unknown;
    const Box& home = tiled_.outline.tiles[tile].box;
    for (std::size_t b = 0; b < outlines_.size(); ++b) {
        const Outline& other = outlines_[b];
        if (b == number_) continue;
        other.for_tiles([&](const Box& box) { return nearness_.is_near(box, home, reach); },
                        [&](std::size_t t) {
                            const Tile& tile = other.tiles[t];
                            nearness_.for_unknown(tile, tiled_.outline.box, home, reach, [&](const Box& box) {
                                unknown.push_back({box, static_cast<std::uint32_t>(b), tile.largest_weight,
                                                   distance_squared(box, home)});
                            });
                        });
    }
    return unknown;
}

}  // namespace votess::blocks

// The requests of a block to others, and its replies.
#include <algorithm>
#include <cmath>
#include <deque>

#include "core/arithmetic.hpp"
#include "distributed/blocks/local_block.hpp"
#include "query/locator.hpp"

namespace votess::blocks {

// Finds the pending cells of one tile after the other. One per thread.
class LocalBlock::Requester {
public:
    explicit Requester(const LocalBlock& block)
        : block_(block),
          builder_(block.all_.clipper.seeds(), block.all_.clipper.hierarchy(),
                   *cpu::find_kernels(block.whole_.instructions)) {
        builder_.begin_job(*block.all_.job.domain);
        for (std::size_t b = 0; b < block.outlines_.size(); ++b)
            if (b != block.number_) heaviest_ = std::max(heaviest_, block.outlines_[b].largest_weight);
        longest_ = block.longest_reach(heaviest_);
    }

    std::uint64_t tested = 0, faces = 0;

    struct Pending {
        std::uint32_t cell;
        std::vector<std::uint32_t> blocks;  // that get the request
        double reach;
    };
    std::vector<Pending> pending_of_tile(std::size_t tile) {
        std::vector<Pending> pending;
        for_tested(tile, [&](std::size_t cell, double reach) { test(cell, reach, pending); });
        return pending;
    }
    // Adds the cells of a tile that have to be tested: those that may reach a box of unknown seeds.
    void add_tested(std::size_t tile, std::vector<std::int32_t>& cells) {
        for_tested(tile, [&](std::size_t cell, double) { cells.push_back(static_cast<std::int32_t>(cell)); });
    }

private:
    // Calls visit(cell, reach). Then near_ are the boxes within reach.
    template <class Visit>
    void for_tested(std::size_t tile, const Visit& visit) {
        if (!block_.any_near(tile, longest_)) return;
        const std::size_t begin = block_.tiled_.begin[tile], end = block_.tiled_.begin[tile + 1];
        double farthest = 0;
        reaches_.assign(end - begin, -1);
        for (std::size_t k = begin; k < end; ++k) {
            const std::size_t cell = block_.tiled_.order[k];
            if (block_.all_.result.status[cell] != CellStatus::certified) continue;
            farthest = std::max(farthest, reaches_[k - begin] = block_.all_.reach_of(cell, heaviest_));
        }
        std::vector<Unknown> unknown = block_.unknown_near(tile, farthest);
        std::ranges::sort(unknown, {}, &Unknown::from_tile);
        for (std::size_t k = begin; k < end && !unknown.empty(); ++k) {
            const std::size_t cell = block_.tiled_.order[k];
            const double reach = reaches_[k - begin];
            if (reach < 0) continue;
            near_.clear();
            for (const Unknown& one : unknown) {
                if (one.from_tile > reach * reach) break;
                if (distance_squared(block_.places_[cell], one.box) <= reach * reach) near_.push_back(&one);
            }
            if (!near_.empty()) visit(cell, reach);
        }
    }

    // Returns the cell of an own seed, clipped by its neighbors again.
    cpu::Cell& from_neighbors(std::size_t number) {
        const auto neighbors = block_.all_.neighbors(number);
        const auto shifts = block_.all_.shifts(number);
        const auto own = static_cast<std::size_t>(block_.positions_[number]);
        const cpu::SeedImages* const images = block_.all_.clipper.seeds().images;
        neighbors_.clear();
        shifts_.clear();
        for (std::size_t e = 0; e < neighbors.size(); ++e) {
            if (neighbors[e] < 0) continue;
            const std::int32_t neighbor = block_.positions_[static_cast<std::size_t>(neighbors[e])];
            neighbors_.push_back(neighbor);
            if (images == nullptr) continue;
            exact::Shift shift = images->shift_in_domain(neighbor, own);
            for (std::size_t j = 0; j < 3; ++j) shift[j] = shifts[3 * e + j] - shift[j];
            shifts_.push_back(shift);
        }
        return images == nullptr ? builder_.build_from(own, neighbors_) : builder_.build_from(own, neighbors_, shifts_);
    }

    // Adds the cell when it reaches a box of unknown seeds.
    void test(std::size_t number, double reach, std::vector<Pending>& pending) {
        cpu::Cell& cell = from_neighbors(number);
        ++tested;
        const double weight = block_.weight_of(number);
        // The reach so far is that of the cell and its neighbors.
        reach = std::min(reach, reach_within(cell.radius_squared(), heaviest_ - weight));
        std::vector<std::uint32_t> blocks;
        for (const Unknown* one : near_) {
            if (distance_squared(block_.places_[number], one->box) > reach * reach) continue;
            if (std::ranges::find(blocks, one->block) != blocks.end()) continue;
            const Box seen = cpu::seen_from(block_.places_[number], one->box);
            if (cell.in_reach(seen, std::max(0.0, one->largest_weight - weight))) blocks.push_back(one->block);
        }
        if (blocks.empty()) return;
        Pending& one = pending.emplace_back();
        one.cell = static_cast<std::uint32_t>(number);
        one.blocks = std::move(blocks);
        cell.canonical_faces(faces_);
        faces += faces_.size();
        one.reach = reach;
    }

    const LocalBlock& block_;
    cpu::CellBuilder builder_;
    double heaviest_ = -std::numeric_limits<double>::infinity();
    double longest_ = 0;  // bounds the reach of all cells
    cpu::CellFaces faces_;
    std::vector<std::int32_t> neighbors_;
    std::vector<exact::Shift> shifts_;
    std::vector<double> reaches_;
    std::vector<const Unknown*> near_;
};

void LocalBlock::make_requests() {
    const std::size_t tiles = tiled_.outline.tiles.size();
    requests_.assign(outlines_.size(), {});
    std::vector<std::vector<Requester::Pending>> pending(tiles);
    ThreadPool& pool = all_.clipper.pool();
    std::deque<Requester> requesters;
    for (unsigned k = 0; k < pool.size(); ++k) requesters.emplace_back(*this);
    if (!all_.has_rows()) {
        std::vector<std::vector<std::int32_t>> tested(pool.size());
        pool.run(tiles,
                 [&](std::size_t tile, unsigned worker) { requesters[worker].add_tested(tile, tested[worker]); });
        std::vector<std::int32_t> cells;
        for (const auto& some : tested) cells.insert(cells.end(), some.begin(), some.end());
        std::ranges::sort(cells);
        if (!cells.empty()) all_.clip_rows(std::move(cells));
    }
    pool.run(tiles,
             [&](std::size_t tile, unsigned worker) { pending[tile] = requesters[worker].pending_of_tile(tile); });
    for (const auto& of_tile : pending)
        for (const Requester::Pending& one : of_tile) {
            pending_.push_back(one.cell);
            const std::size_t kept = kept_neighbors_.size();
            for (const std::int32_t i : all_.neighbors(one.cell))
                if (i >= 0) kept_neighbors_.push_back(i);
            for (const std::uint32_t b : one.blocks) {
                requests_[b].cells.add(all_.seeds, one.cell);
                requests_[b].reaches.push_back({places_[one.cell], one.reach});
                for (std::size_t k = kept; k < kept_neighbors_.size(); ++k)
                    requests_[b].neighbors.add(all_.seeds, static_cast<std::size_t>(kept_neighbors_[k]));
                ++counts_.questions;
            }
        }
    for (Requests& some : requests_) some.neighbors = some.neighbors.sorted();
    std::ranges::sort(pending_);
    for (const Requester& requester : requesters) {
        counts_.tested += requester.tested;
        pending_faces_ += requester.faces;
    }
}

NearSeeds::NearSeeds(const Job& job, const Outline& outline, std::span<const Requests> requests) : job_(job) {
    const Nearness nearness(*job.domain);
    std::vector<bool> is_near(outline.tiles.size());
    for (const Requests& some : requests)
        for (const Requests::Reach& reach : some.reaches)
            outline.for_tiles(
                [&](const Box& box) {
                    return nearness.is_near(box, {reach.place, reach.place}, reach.distance);
                },
                [&](std::size_t tile) { is_near[tile] = true; });
    std::vector<Tile> tiles;
    for (std::size_t t = 0; t < is_near.size(); ++t)
        if (is_near[t]) tiles.push_back(outline.tiles[t]);
    near_ = outline_of(std::move(tiles));
}

void NearSeeds::add(const Seeds& some, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const auto place = cpu::place_in(*job_.domain, point_of(some.points, i, job_.scale));
        bool found = false;
        near_.for_tiles([&](const Box& box) { return !found && place && distance_squared(place->at, box) == 0; },
                        [&](std::size_t) { found = true; });
        if (found) found_.add(some, i);
    }
}

std::vector<Seeds> reply(const Settled& whole, const NearSeeds& near_seeds, std::span<const Requests> requests) {
    std::vector<Seeds> replies(requests.size());
    const Seeds& near = near_seeds.found();
    Seeds cells, others = near;
    for (const Requests& some : requests) {
        cells.add(some.cells);
        others.add(some.neighbors);
    }
    if (cells.size() == 0 || near.size() == 0) return replies;
    cells = cells.sorted();
    Run run;
    run.seeds = with_others(cells, others);
    Settled lists = whole;
    lists.want = {};
    lists.want.volumes = false;
    run.clip(lists, cells.size());

    // By cell: indices of seeds.
    std::vector<std::vector<std::int32_t>> found(cells.size());
    cpu::CellBuilder builder(run.clipper.seeds(), run.clipper.hierarchy(), *cpu::find_kernels(whole.instructions));
    builder.begin_job(*run.job.domain);
    const auto& input = run.clipper.seeds().input;
    for (std::size_t s = 0; s < input.size(); ++s) {
        const auto cell = static_cast<std::size_t>(input[s]);
        if (cell >= cells.size()) continue;
        if (run.result.status[cell] != CellStatus::certified) {
            // Any of its planes may be why the cell is empty.
            for (const cpu::CellPlane& plane : builder.build(s).planes())
                if (plane.id >= 0) found[cell].push_back(input[static_cast<std::size_t>(plane.id)]);
            continue;
        }
        for (auto e = run.result.indptr[cell]; e < run.result.indptr[cell + 1]; ++e) {
            const std::int32_t i = run.result.indices[static_cast<std::size_t>(e)];
            if (i >= 0 && std::ranges::binary_search(near.ids, run.seeds.ids[static_cast<std::size_t>(i)]))
                found[cell].push_back(i);
        }
    }
    for (std::size_t r = 0; r < requests.size(); ++r) {
        for (const std::int64_t id : requests[r].cells.ids)
            for (const std::int32_t i : found[place_of(id, cells.ids)])
                replies[r].add(run.seeds, static_cast<std::size_t>(i));
        replies[r] = replies[r].sorted();
    }
    return replies;
}

std::vector<Seeds> LocalBlock::reply(std::span<const Requests> requests) const {
    NearSeeds near(job_, tiled_.outline, requests);
    near.add(all_.seeds, count_);
    return blocks::reply(whole_, near, requests);
}

}  // namespace votess::blocks

// The requests of a block to others, and its replies.
#include <algorithm>
#include <cmath>
#include <deque>

#include "core/arithmetic.hpp"
#include "distributed/blocks/local_block.hpp"
#include "query/locator.hpp"

namespace votess::blocks {
namespace {

constexpr std::size_t replies_at_once = 64;

double distance_squared(const exact::Point& x, const Box& box) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double gap = std::max({0.0, box.lower[k] - x[k], x[k] - box.upper[k]});
        sum += gap * gap;
    }
    return sum;
}

}  // namespace

// Finds the pending cells of one tile after the other. One per thread.
class LocalBlock::Requester {
public:
    explicit Requester(const LocalBlock& block)
        : block_(block),
          builder_(block.all_.clipper.seeds(), block.all_.clipper.hierarchy(),
                   *cpu::find_kernels(block.options_.instructions)) {
        builder_.begin_job(*block.all_.job.domain);
        for (std::size_t b = 0; b < block.outlines_.size(); ++b)
            if (b != block.number_) heaviest_ = std::max(heaviest_, block.outlines_[b].largest_weight);
        longest_ = block.longest_reach(heaviest_);
    }

    std::uint64_t tested = 0, faces = 0;
    std::vector<std::int32_t> kept_neighbors;

    struct Pending {
        std::uint32_t cell;
        std::vector<std::uint32_t> blocks;  // that get the request
        Requests::Cell request;
        std::vector<Requests::Guard> guards;
    };
    std::vector<Pending> pending_of_tile(std::size_t tile) {
        if (!block_.any_near(tile, longest_)) return {};
        const std::size_t begin = block_.tiled_.begin[tile], end = block_.tiled_.begin[tile + 1];
        double farthest = 0;
        reaches_.assign(end - begin, -1);
        for (std::size_t k = begin; k < end; ++k) {
            const std::size_t cell = block_.tiled_.order[k];
            if (block_.all_.result.status[cell] != CellStatus::certified) continue;
            farthest = std::max(farthest, reaches_[k - begin] = block_.all_.reach_of(cell, heaviest_));
        }
        std::vector<Pending> pending;
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
            if (!near_.empty()) test(cell, reach, pending);
        }
        return pending;
    }

private:
    // Returns the cell of an own seed, clipped by its neighbors again.
    cpu::Cell& from_neighbors(std::size_t number) {
        const detail::Result& result = block_.all_.result;
        const auto own = static_cast<std::size_t>(block_.positions_[number]);
        const cpu::SeedImages* const images = block_.all_.clipper.seeds().images;
        neighbors_.clear();
        shifts_.clear();
        for (auto e = static_cast<std::size_t>(result.indptr[number]);
             e < static_cast<std::size_t>(result.indptr[number + 1]); ++e) {
            if (result.indices[e] < 0) continue;
            const std::int32_t neighbor = block_.positions_[static_cast<std::size_t>(result.indices[e])];
            neighbors_.push_back(neighbor);
            if (images == nullptr) continue;
            exact::Shift shift = images->shift_in_domain(neighbor, own);
            for (std::size_t j = 0; j < 3; ++j) shift[j] = result.shifts[3 * e + j] - shift[j];
            shifts_.push_back(shift);
        }
        return images == nullptr ? builder_.build_from(own, neighbors_) : builder_.build_from(own, neighbors_, shifts_);
    }

    // Adds the cell when it reaches a box of unknown seeds.
    void test(std::size_t number, double reach, std::vector<Pending>& pending) {
        const std::int32_t own = block_.positions_[number];
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
        const auto& input = block_.all_.clipper.seeds().input;
        for (const std::int32_t p : faces_.planes) {
            const cpu::CellPlane& plane = cell.planes()[static_cast<std::size_t>(p)];
            if (plane.id < 0 || plane.id == own) continue;
            kept_neighbors.push_back(input[static_cast<std::size_t>(plane.id)]);
            one.guards.push_back({plane.source.seed, plane.source.shift, plane.source.power});
        }
        one.request = {block_.probe_of(number), reach, one.guards.size()};
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

// Returns the seed of a cell in the coordinates of its planes.
cpu::Probe LocalBlock::probe_of(std::size_t cell) const {
    const auto position = static_cast<std::size_t>(positions_[cell]);
    const auto& seeds = all_.clipper.seeds();
    cpu::Probe probe;
    probe.place.at = places_[cell];
    probe.weight = weight_of(cell);
    if (seeds.images == nullptr) {
        probe.x = probe.place.at;
        return probe;
    }
    const cpu::SeedImages::Base base = seeds.images->base(position);
    probe.x = base.point;
    probe.place.shift = base.shift;
    probe.place.low = seeds.images->low(static_cast<std::int32_t>(position));
    return probe;
}

void LocalBlock::make_requests() {
    const std::size_t tiles = tiled_.outline.tiles.size();
    requests_.assign(outlines_.size(), {});
    std::vector<std::vector<Requester::Pending>> pending(tiles);
    ThreadPool& pool = all_.clipper.pool();
    std::deque<Requester> requesters;
    for (unsigned k = 0; k < pool.size(); ++k) requesters.emplace_back(*this);
    pool.run(tiles,
             [&](std::size_t tile, unsigned worker) { pending[tile] = requesters[worker].pending_of_tile(tile); });
    for (const auto& of_tile : pending)
        for (const Requester::Pending& one : of_tile) {
            pending_.push_back(one.cell);
            for (const std::uint32_t b : one.blocks) {
                requests_[b].cells.push_back(one.request);
                requests_[b].guards.insert(requests_[b].guards.end(), one.guards.begin(), one.guards.end());
                ++counts_.questions;
            }
        }
    std::ranges::sort(pending_);
    for (const Requester& requester : requesters) {
        counts_.tested += requester.tested;
        pending_faces_ += requester.faces;
        kept_neighbors_.insert(kept_neighbors_.end(), requester.kept_neighbors.begin(), requester.kept_neighbors.end());
    }
}

// Cuts cells of other blocks. One per thread.
class Responder::Worker {
public:
    explicit Worker(const Responder& responder)
        : seeds_(responder.run_.clipper.seeds()),
          domain_(*responder.run_.job.domain),
          builder_(seeds_, responder.run_.clipper.hierarchy(), *cpu::find_kernels(responder.options_.instructions)) {
        builder_.begin_job(domain_);
    }

    std::vector<std::int32_t> found;  // seeds of the run

    void cut(const Requests::Cell& request, std::span<const Requests::Guard> guards) {
        planes_.clear();
        for (const Requests::Guard& guard : guards) {
            exact::Plane plane = exact::Plane::bisector(guard.q, guard.shift, domain_.lattice);
            plane.power = guard.power;
            planes_.push_back(plane);
        }
        cpu::Cell& cell = builder_.build(request.seed, planes_);
        constexpr std::size_t min_faces = 4;
        if (!cell.empty()) cell.canonical_faces(faces_);
        if (cell.empty() || faces_.size() < min_faces) {
            // The cell is empty or has no volume. Any of its planes may be why.
            for (const cpu::CellPlane& plane : cell.planes()) add(plane.id);
            return;
        }
        for (const std::int32_t p : faces_.planes) add(cell.planes()[static_cast<std::size_t>(p)].id);
    }

private:
    void add(std::int32_t id) {
        if (id >= 0 && static_cast<std::size_t>(id) < seeds_.size())
            found.push_back(seeds_.input[static_cast<std::size_t>(id)]);
    }

    const cpu::SortedSeeds& seeds_;
    const Domain& domain_;
    cpu::CellBuilder builder_;
    std::vector<exact::Plane> planes_;
    cpu::CellFaces faces_;
};

Seeds Responder::reply(const Requests& requests) const {
    Seeds seeds;
    if (requests.cells.empty()) return seeds;
    std::vector<std::size_t> begin{0};
    for (const Requests::Cell& cell : requests.cells) begin.push_back(begin.back() + cell.guards);
    ThreadPool& pool = run_.clipper.pool();
    std::deque<Worker> workers;
    for (unsigned k = 0; k < pool.size(); ++k) workers.emplace_back(*this);
    const std::size_t count = requests.cells.size();
    pool.run(ceil_div(count, replies_at_once), [&](std::size_t task, unsigned worker) {
        for (std::size_t q = task * replies_at_once; q < std::min(count, (task + 1) * replies_at_once); ++q)
            workers[worker].cut(requests.cells[q],
                                std::span(requests.guards).subspan(begin[q], begin[q + 1] - begin[q]));
    });
    std::vector<std::int32_t> found;
    for (const Worker& worker : workers) found.insert(found.end(), worker.found.begin(), worker.found.end());
    std::ranges::sort(found);
    const auto [end, last] = std::ranges::unique(found);
    found.erase(end, last);
    for (const std::int32_t i : found) seeds.add(run_.seeds, static_cast<std::size_t>(i));
    return seeds;
}

Seeds LocalBlock::reply(const Requests& requests) {
    return Responder(options_, all_).reply(requests);
}

void mark_near(const Outline& outline, const Nearness& nearness, const Requests& requests, std::vector<bool>& near) {
    for (const Requests::Cell& cell : requests.cells) {
        const Box home{cell.seed.place.at, cell.seed.place.at};
        outline.for_tiles([&](const Box& box) { return nearness.is_near(box, home, cell.reach); },
                          [&](std::size_t tile) { near[tile] = true; });
    }
}

}  // namespace votess::blocks

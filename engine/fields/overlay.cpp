#include "fields/overlay.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <vector>

#include "core/progress.hpp"

namespace votess::fields {
namespace {

constexpr std::size_t bodies_of_task = 4096;  // when tiles get their lists
constexpr std::size_t bodies_per_look = 16;   // after which the user may stop
// A body is vague if it fills less of its bounds, or if its polygons are less planar. The volumes of its parts need not
// sum to its own.
constexpr double min_filled = 1e-4, max_unevenness = 1e-13;

// The state of a thread.
struct Worker {
    std::unique_ptr<Carrier> carrier;
    Slicer<ConvexPiece> slicer;
    Body body;
    ConvexPiece copy;
};

// A vague body, and the sum of the volumes of its parts. The sum is 0 if rounding left no part. The body then goes
// whole to the grid cell of its first corner.
struct VagueBody {
    std::uint64_t number;
    double volume;
};

// Calls visit(place) for the places of a window that are `step` apart.
template <class Visit>
void for_places(const Window& window, const Cell& step, const Visit& visit) {
    for (std::int64_t x = window[0].first; x <= window[0].last; x += step[0])
        for (std::int64_t y = window[1].first; y <= window[1].last; y += step[1])
            for (std::int64_t z = window[2].first; z <= window[2].last; z += step[2]) visit(Cell{x, y, z});
}

bool is_vague(const ConvexPiece& piece, double volume) {
    double bounds = 1;
    for (const Vector& axis : Place{}.along) {
        const auto [least, largest] = piece.extent(axis);
        bounds *= largest - least;
    }
    return !(volume > min_filled * bounds && std::abs(piece.volume(1) - volume) < max_unevenness * volume);
}

class Overlay {
public:
    Overlay(const Frame& frame, ThreadPool& pool, const MakeCarrier& make_carrier) : frame_(frame), pool_(pool) {
        for (unsigned w = 0; w < pool.size(); ++w)
            workers_.push_back({make_carrier(), Slicer<ConvexPiece>(frame), {}, {}});
        for (std::size_t k = 0; k < 3; ++k) tiles_[k] = frame.axis(k).tiles();
        all_tiles_ = static_cast<std::size_t>(tiles_[0] * tiles_[1] * tiles_[2]);
    }

    void run(std::size_t count) {
        list_bodies(count);
        pool_.run_stage(all_tiles_, [&](std::size_t tile, unsigned worker) {
            for (std::size_t i = begin_[tile]; i < begin_[tile + 1]; ++i) {
                if (i % bodies_per_look == 0) check_stop();
                add(bodies_[i], tile, workers_[worker]);
            }
        });
    }

private:
    // The findings of one task.
    struct Listed {
        std::vector<std::uint64_t> pairs;  // body * all_tiles_ + tile
        std::vector<VagueBody> vague;
    };

    // Finds the bodies that meet each tile, ascending.
    void list_bodies(std::size_t count) {
        std::vector<Listed> listed(ceil_div(count, bodies_of_task));
        pool_.run(listed.size(), [&](std::size_t task, unsigned worker) {
            const std::size_t end = std::min(count, (task + 1) * bodies_of_task);
            for (std::size_t body = task * bodies_of_task; body < end; ++body) {
                if (body % bodies_per_look == 0) check_stop();
                if (workers_[worker].carrier->load(body, workers_[worker].body))
                    list(body, workers_[worker], listed[task]);
            }
        });
        begin_.assign(all_tiles_ + 1, 0);
        for (const Listed& task : listed) {
            check_stop();
            for (const std::uint64_t pair : task.pairs) ++begin_[pair % all_tiles_ + 1];
        }
        for (std::size_t tile = 0; tile < all_tiles_; ++tile) begin_[tile + 1] += begin_[tile];
        bodies_.resize(begin_.back());
        std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
        for (Listed& task : listed) {
            check_stop();
            for (const std::uint64_t pair : task.pairs) bodies_[next[pair % all_tiles_]++] = pair / all_tiles_;
            std::ranges::copy(task.vague, std::back_inserter(vague_));
            task = {};
        }
    }

    void list(std::uint64_t number, Worker& worker, Listed& to) const {
        Window met = tiles_met(worker.body);
        const double volume = worker.body.piece.volume();
        if (is_vague(worker.body.piece, volume)) {
            VagueBody vague{number, 0};
            for_places(met, {1, 1, 1}, [&](const Cell& tile) {
                slice(worker, tile, [&](const Cell&, const ConvexPiece& part) { vague.volume += part.volume(); });
            });
            if (!(vague.volume > volume / 2 && vague.volume < 2 * volume)) {
                vague.volume = 0;
                const Cell home = cell_of_first_corner(worker.body);
                for (std::size_t k = 0; k < 3; ++k) met[k].first = met[k].last = frame_.axis(k).tile_of(home[k]);
            }
            to.vague.push_back(vague);
        }
        // One that is longer than the domain meets a tile more than once, and is listed once.
        for (std::size_t k = 0; k < 3; ++k) met[k].last = std::min(met[k].last, met[k].first + tiles_[k] - 1);
        for_places(met, {1, 1, 1}, [&](const Cell& tile) {
            std::int64_t at = 0;
            for (std::size_t k = 0; k < 3; ++k) at = at * tiles_[k] + modulo(tile[k], tiles_[k]);
            to.pairs.push_back(number * all_tiles_ + static_cast<std::uint64_t>(at));
        });
    }

    // The tiles that a body meets, numbered on beyond a periodic domain.
    [[nodiscard]] Window tiles_met(const Body& body) const {
        Window tiles;
        for (std::size_t k = 0; k < 3; ++k) {
            const Range cells = cover(frame_, body.piece, body.place, k);
            tiles[k] = {frame_.axis(k).tile_of(cells.first), frame_.axis(k).tile_of(cells.last)};
        }
        return tiles;
    }

    [[nodiscard]] Cell cell_of_first_corner(const Body& body) const {
        Cell cell{};
        for (std::size_t k = 0; k < 3; ++k) cell[k] = frame_.cover(k, body.place.at[k], 0, 0).first;
        return cell;
    }

    template <class Take>
    void slice(Worker& worker, const Cell& tile, const Take& take) const {
        Window window;
        for (std::size_t k = 0; k < 3; ++k) window[k] = frame_.axis(k).cells_of(tile[k]);
        worker.copy.assign(worker.body.piece);
        worker.slicer.slice(worker.copy, worker.body.place, window, take);
    }

    // Adds the parts of a body in a tile and, in a periodic domain, in the images of the tile.
    void add(std::uint64_t number, std::size_t tile, Worker& worker) const {
        const Body& body = worker.body;
        worker.carrier->load(number, worker.body);
        const auto vague = std::ranges::lower_bound(vague_, number, {}, &VagueBody::number);
        const bool is_listed = vague != vague_.end() && vague->number == number;
        const double volume = is_listed ? vague->volume : body.piece.volume();
        if (volume == 0) {
            worker.carrier->add(frame_.index(cell_of_first_corner(body)), {1, {}});
            return;
        }
        Window images = tiles_met(body);
        auto rest = static_cast<std::int64_t>(tile);
        for (std::size_t k = 3; k-- > 0; rest /= tiles_[k])
            images[k].first += modulo(rest % tiles_[k] - images[k].first, tiles_[k]);
        for_places(images, tiles_, [&](const Cell& image) {
            slice(worker, image, [&](const Cell& cell, const ConvexPiece& part) {
                ConvexPiece::Measure share = part.measure();
                share.volume /= volume;
                for (double& x : share.moment) x /= volume;
                worker.carrier->add(frame_.index(cell), share);
            });
        });
    }

    const Frame& frame_;
    ThreadPool& pool_;
    std::vector<Worker> workers_;
    Cell tiles_{};  // along each axis
    std::size_t all_tiles_ = 1;
    std::vector<std::size_t> begin_;     // by tile, and the end of the last
    std::vector<std::uint64_t> bodies_;  // of the tiles, one after the other
    std::vector<VagueBody> vague_;       // ascending
};

}  // namespace

void overlay(const Frame& frame, ThreadPool& pool, std::size_t count, const MakeCarrier& make_carrier) {
    Overlay(frame, pool, make_carrier).run(count);
}

}  // namespace votess::fields

// Where the seeds of a block are, for other blocks: tiles, which are boxes around some hundred seeds each.
//
// Each tile has a width, some spacings of its seeds. A block sends another block the seeds of each tile within its
// width of that block's box: the halo, together with all tiles. Both blocks have the boxes, so both can compute where
// seeds may be that the other one lacks. Blocks that get no seed get one box around all.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/box.hpp"
#include "core/thread_pool.hpp"
#include "domain/domain.hpp"

namespace votess::blocks {

struct Tile {
    Box box;  // around its seeds, times the scale of the job
    double width = 0;
    double largest_weight = 0;
};

struct Outline {
    Box box;  // around all tiles
    double largest_weight = 0;
    std::vector<Tile> tiles;  // empty when the block has no seeds
    std::vector<Box> around;  // a tree over the tiles: a node, the tree of its first half, the tree of its second half

    // Calls visit(number) for tiles whose boxes pass the test, as well as all boxes around them.
    template <class Test, class Visit>
    void for_tiles(const Test& test, const Visit& visit) const {
        if (!tiles.empty()) for_tiles(test, visit, 0, 0, tiles.size());
    }

private:
    template <class Test, class Visit>
    void for_tiles(const Test& test, const Visit& visit, std::size_t node, std::size_t begin, std::size_t end) const {
        if (!test(around[node])) return;
        if (end - begin == 1) return visit(begin);
        const std::size_t middle = begin + (end - begin) / 2;
        for_tiles(test, visit, node + 1, begin, middle);
        for_tiles(test, visit, node + 2 * (middle - begin), middle, end);
    }
};

VOTESS_API Outline outline_of(std::vector<Tile> tiles);
// Returns one tile of width 0, for blocks that get no halo.
VOTESS_API Outline summary_of(const Outline& outline);

// An outline and the seeds of its tiles: those of tile t are order[begin[t] .. begin[t + 1]).
struct TiledSeeds {
    Outline outline;
    std::vector<std::uint32_t> order;
    std::vector<std::size_t> begin;
};
TiledSeeds tile_seeds(const std::vector<exact::Point>& places, std::span<const double> weights, ThreadPool& pool);

// Finds the images of boxes and places that are near each other.
class Nearness {
public:
    explicit Nearness(const Domain& domain);

    // The part of a tile in the halo of the block with the box `known`.
    struct Halo {
        Box box;                                // `known`, wider by the tile's width
        std::vector<std::array<double, 3>> by;  // translations of images that may be in it
    };
    [[nodiscard]] Halo halo_of(const Tile& tile, const Box& known) const;
    [[nodiscard]] static bool holds(const Halo& halo, const exact::Point& place);

    // Visits boxes that hold all images of the tile's seeds nearer than `distance` to the box `home`, except those in
    // the halo of the block with the box `known`.
    void for_unknown(const Tile& tile, const Box& known, const Box& home, double distance,
                     const std::function<void(const Box&)>& visit) const;
    // Returns false only when no image of `box` is nearer than `distance` to `home`.
    [[nodiscard]] bool is_near(const Box& box, const Box& home, double distance) const;

private:
    // Calls task(translation) for images of `box` that may be nearer than `distance` to `home`. Returns false, without
    // a call, when there are too many.
    template <class Task>
    bool for_images(const Box& box, const Box& home, double distance, const Task& task) const;

    // Returns a bound on the rounding of places in two boxes, which may lie beyond walls, and of translations.
    [[nodiscard]] double rounding_of(const Box& box, const Box& other) const;

    const Domain& domain_;
    double size_ = 0;  // of the domain
};

}  // namespace votess::blocks

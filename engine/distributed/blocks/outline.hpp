// Where the seeds of a block lie, for blocks that do not have them: boxes around some hundred seeds each.
//
// Each tile has a width, some spacings of its seeds. To another block it gives from the start those of its seeds that
// lie within this width of the box of that block: its layer, and its tiles with it. Both know the boxes, so both know
// where seeds may be that the other one was not given. Blocks that are given no seed know of one box around all.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/thread_pool.hpp"
#include "domain/domain.hpp"

namespace votess::blocks {

struct Tile {
    Box box;  // of places, times the scale of the job
    double width = 0;
    double largest_weight = 0;
};

struct Outline {
    Box box;  // around all tiles
    double largest_weight = 0;
    std::vector<Tile> tiles;  // none where the block has no seeds
    std::vector<Box> around;  // around both halves of the tiles, then the halves of the first half, and so on

    // Calls visit(number) for tiles whose boxes, and those around them, pass the test.
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

// Returns that of two boxes; 0 where they meet.
double distance_squared(const Box& a, const Box& b);

Outline outline_of(std::vector<Tile> tiles);
// One tile without a width, for blocks that were given no layer: it claims no seed near them.
Outline summary_of(const Outline& outline);

// An outline, and the seeds in the order of its tiles: those of tile t are order[begin[t] .. begin[t + 1]).
struct TiledSeeds {
    Outline outline;
    std::vector<std::uint32_t> order;
    std::vector<std::size_t> begin;
};
TiledSeeds tile_seeds(const std::vector<exact::Point>& places, std::span<const double> weights, ThreadPool& pool);

// Knows which images of boxes and places are near each other.
class Nearness {
public:
    explicit Nearness(const Domain& domain);

    // Whether the layer that the block of `known` gets has a seed of the tile at that place. layer: layer_of() the two.
    struct Layer {
        Box box;                                // known, wider by the tile's width
        std::vector<std::array<double, 3>> by;  // translations of images that may lie in it
    };
    [[nodiscard]] Layer layer_of(const Tile& tile, const Box& known) const;
    [[nodiscard]] static bool holds(const Layer& layer, const exact::Point& place);

    // Visits boxes that hold all images of the tile's seeds nearer than `distance` to the box `home`, but for those
    // that the layer of the block of `known` has.
    void for_unknown(const Tile& tile, const Box& known, const Box& home, double distance,
                     const std::function<void(const Box&)>& visit) const;
    // Whether some image of `box` may lie nearer than `distance` to `home`.
    [[nodiscard]] bool is_near(const Box& box, const Box& home, double distance) const;

private:
    // Calls task(translation) for images of `box` that may lie nearer than `distance` to `home`; false where they are
    // too many, without any call.
    template <class Task>
    bool for_images(const Box& box, const Box& home, double distance, const Task& task) const;

    const Domain& domain_;
    double rounding_ = 0;  // of places and translations
};

}  // namespace votess::blocks

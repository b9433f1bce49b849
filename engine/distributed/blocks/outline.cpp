#include "distributed/blocks/outline.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace votess::blocks {
namespace {

constexpr std::size_t max_tile_seeds = 512;
constexpr double halo_spacings = 2.5;  // nearly all cells at a border have a smaller reach
constexpr std::size_t max_images = 512;

using Vector = std::array<double, 3>;

Box moved(const Box& box, const Vector& by) {
    Box result;
    for (std::size_t k = 0; k < 3; ++k) result.lower[k] = box.lower[k] + by[k], result.upper[k] = box.upper[k] + by[k];
    return result;
}

Box wider(const Box& box, double by) {
    return moved({{box.lower[0] - 2 * by, box.lower[1] - 2 * by, box.lower[2] - 2 * by}, box.upper}, {by, by, by});
}

// Splits seeds at about the median of the longest side until tiles are small enough.
class Tiler {
public:
    struct Seed {
        exact::Point x;
        std::uint32_t number;
    };
    struct Range {
        std::size_t begin, end;
    };
    struct Tiles {
        std::vector<Tile> tiles;
        std::vector<std::size_t> ends;
    };

    Tiler(const std::vector<exact::Point>& places, std::span<const double> weights) : weights_(weights) {
        seeds_.reserve(places.size());
        for (const exact::Point& x : places) seeds_.push_back({x, static_cast<std::uint32_t>(seeds_.size())});
    }

    // Splits the range until no part has more than max_seeds seeds. Adds the parts in order.
    void split(Range range, std::size_t max_seeds, std::vector<Range>& out) {
        const std::size_t middle = range.end - range.begin > max_seeds ? divide(range, box_of(range)) : range.begin;
        if (middle == range.begin) return out.push_back(range);
        split({range.begin, middle}, max_seeds, out);
        split({middle, range.end}, max_seeds, out);
    }

    void make_tiles(Range range, Tiles& out) {
        std::vector<Range> ranges;
        split(range, max_tile_seeds, ranges);
        for (const Range& of_tile : ranges) {
            Tile tile{box_of(of_tile), 0, -infinity};
            double volume = 1, dimensions = 0;
            for (std::size_t k = 0; k < 3; ++k)
                if (const double side = tile.box.upper[k] - tile.box.lower[k]; side > 0) volume *= side, ++dimensions;
            if (dimensions > 0)
                tile.width =
                    halo_spacings * std::pow(volume / static_cast<double>(of_tile.end - of_tile.begin), 1 / dimensions);
            for (std::size_t k = of_tile.begin; k < of_tile.end; ++k)
                tile.largest_weight = std::max(tile.largest_weight, weights_.empty() ? 0 : weights_[seeds_[k].number]);
            out.tiles.push_back(tile);
            out.ends.push_back(of_tile.end);
        }
    }

    [[nodiscard]] std::vector<std::uint32_t> order() const {
        std::vector<std::uint32_t> order;
        order.reserve(seeds_.size());
        for (const Seed& seed : seeds_) order.push_back(seed.number);
        return order;
    }

private:
    [[nodiscard]] Box box_of(Range range) const {
        Box box = empty_box;
        for (std::size_t k = range.begin; k < range.end; ++k) include(box, seeds_[k].x);
        return box;
    }

    // Returns where the second half begins, or the range's begin when all seeds are at one place. Seeds at one place
    // stay together, so that a halo has all or none of them.
    std::size_t divide(Range range, const Box& box) {
        std::size_t axis = 0;
        for (std::size_t k = 1; k < 3; ++k)
            if (box.upper[k] - box.lower[k] > box.upper[axis] - box.lower[axis]) axis = k;
        const auto at = [&](std::size_t k) { return seeds_.begin() + static_cast<std::ptrdiff_t>(k); };
        const auto before = [axis](const Seed& a, const Seed& b) {
            return a.x[axis] != b.x[axis] ? a.x[axis] < b.x[axis] : a.x < b.x;
        };
        const std::size_t count = range.end - range.begin;
        // The median of a sample saves passes over all.
        std::array<Seed, 63> sample;
        for (std::size_t k = 0; k < sample.size(); ++k) sample[k] = seeds_[range.begin + count * k / sample.size()];
        const auto pivot = sample.begin() + sample.size() / 2;
        std::nth_element(sample.begin(), pivot, sample.end(), before);
        const auto second =
            std::partition(at(range.begin), at(range.end), [&](const Seed& seed) { return before(seed, *pivot); });
        if (second != at(range.begin)) return static_cast<std::size_t>(second - seeds_.begin());
        const auto middle = at(range.begin + count / 2);
        std::nth_element(at(range.begin), middle, at(range.end), before);
        const exact::Point first = middle->x;
        const auto moved = std::partition(at(range.begin), middle, [&](const Seed& seed) { return seed.x != first; });
        return static_cast<std::size_t>(moved - seeds_.begin());
    }

    std::vector<Seed> seeds_;
    std::span<const double> weights_;
};

Box boxes_around(const std::vector<Tile>& tiles, std::size_t node, std::size_t begin, std::size_t end,
                 std::vector<Box>& around) {
    if (end - begin == 1) return around[node] = tiles[begin].box;
    const std::size_t middle = begin + (end - begin) / 2;
    Box box = boxes_around(tiles, node + 1, begin, middle, around);
    include(box, boxes_around(tiles, node + 2 * (middle - begin), middle, end, around));
    return around[node] = box;
}

}  // namespace

TiledSeeds tile_seeds(const std::vector<exact::Point>& places, std::span<const double> weights, ThreadPool& pool) {
    TiledSeeds tiled;
    tiled.begin.assign(1, 0);
    tiled.outline = outline_of({});
    if (places.empty()) return tiled;
    Tiler tiler(places, weights);
    std::vector<Tiler::Range> tasks;
    tiler.split({0, places.size()}, std::max(max_tile_seeds, places.size() / (4 * std::size_t{pool.size()})), tasks);
    std::vector<Tiler::Tiles> of_task(tasks.size());
    pool.run(tasks.size(), [&](std::size_t k, unsigned) { tiler.make_tiles(tasks[k], of_task[k]); });
    std::vector<Tile> tiles;
    for (const Tiler::Tiles& some : of_task) {
        tiles.insert(tiles.end(), some.tiles.begin(), some.tiles.end());
        tiled.begin.insert(tiled.begin.end(), some.ends.begin(), some.ends.end());
    }
    tiled.order = tiler.order();
    tiled.outline = outline_of(std::move(tiles));
    return tiled;
}

Outline outline_of(std::vector<Tile> tiles) {
    Outline outline{empty_box, -infinity, std::move(tiles), {}};
    for (const Tile& tile : outline.tiles)
        outline.largest_weight = std::max(outline.largest_weight, tile.largest_weight);
    if (outline.tiles.empty()) return outline;
    outline.around.resize(2 * outline.tiles.size() - 1);
    outline.box = boxes_around(outline.tiles, 0, 0, outline.tiles.size(), outline.around);
    return outline;
}

Outline summary_of(const Outline& outline) {
    if (outline.tiles.empty()) return outline;
    return outline_of({{outline.box, 0, outline.largest_weight}});
}

Nearness::Nearness(const Domain& domain) : domain_(domain) {
    size_ = largest_coordinate(domain.box);
    for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t k = 0; k < 3; ++k) size_ = std::max(size_, std::abs(domain.vector[j][k]));
}

double Nearness::rounding_of(const Box& box, const Box& other) const {
    if (!domain_.is_periodic()) return 0;
    return 0x1p-48 * std::max({size_, largest_coordinate(box), largest_coordinate(other)});
}

template <class Task>
bool Nearness::for_images(const Box& box, const Box& home, double distance, const Task& task) const {
    if (!domain_.is_periodic()) {
        if (distance_squared(box, home) <= distance * distance) task(Vector{});
        return true;
    }
    exact::Point middle;
    double half = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        middle[k] = 0.5 * (home.lower[k] + home.upper[k]);
        half += 0.25 * (home.upper[k] - home.lower[k]) * (home.upper[k] - home.lower[k]);
    }
    const double rounding = rounding_of(box, home);
    const double reach = (distance + std::sqrt(half)) * (1 + 1e-9) + 4 * rounding;
    const ShiftRange range = shifts_around(domain_, box, middle, reach);
    double images = 1;
    for (std::size_t j = 0; j < 3; ++j) images *= static_cast<double>(range.upper[j]) - range.lower[j] + 1;
    if (!(images <= max_images)) return false;
    const double near = distance + 4 * rounding;
    ShiftRange one = range;
    for (one.lower[0] = range.lower[0]; one.lower[0] <= range.upper[0]; ++one.lower[0])
        for (one.lower[1] = range.lower[1]; one.lower[1] <= range.upper[1]; ++one.lower[1])
            for (one.lower[2] = range.lower[2]; one.lower[2] <= range.upper[2]; ++one.lower[2]) {
                one.upper = one.lower;
                const Vector by = domain_.translation(only_shift(domain_, one));
                if (distance_squared(moved(box, by), home) <= near * near) task(by);
            }
    return true;
}

Nearness::Halo Nearness::halo_of(const Tile& tile, const Box& known) const {
    Halo halo{wider(known, tile.width), {}};
    (void)for_images(tile.box, halo.box, 0, [&](const Vector& by) { halo.by.push_back(by); });
    return halo;
}

bool Nearness::holds(const Halo& halo, const exact::Point& place) {
    return std::ranges::any_of(halo.by, [&](const Vector& by) {
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = place[k] + by[k];
            if (!(x >= halo.box.lower[k] && x <= halo.box.upper[k])) return false;
        }
        return true;
    });
}

bool Nearness::is_near(const Box& box, const Box& home, double distance) const {
    bool near = false;
    return !for_images(box, home, distance, [&](const Vector&) { near = true; }) || near;
}

void Nearness::for_unknown(const Tile& tile, const Box& known, const Box& home, double distance,
                           const std::function<void(const Box&)>& visit) const {
    const Halo halo = halo_of(tile, known);
    const double rounding = rounding_of(tile.box, home);
    const auto near = [&](const Box& piece) {
        if (distance_squared(piece, home) <= distance * distance) visit(piece);
    };
    const auto outside_halo = [&](const Vector& by) {
        // The halo is cut from the image slab by slab. The pieces are widened by the rounding.
        Box rest = moved(tile.box, by);
        if (halo.by.empty() || distance_squared(rest, halo.box) > 0) return near(wider(rest, rounding));
        for (std::size_t k = 0; k < 3; ++k) {
            for (const bool upper : {false, true}) {
                Box piece = rest;
                if (upper)
                    piece.lower[k] = std::max(piece.lower[k], halo.box.upper[k]);
                else
                    piece.upper[k] = std::min(piece.upper[k], halo.box.lower[k]);
                const bool any = upper ? rest.upper[k] > halo.box.upper[k] : rest.lower[k] < halo.box.lower[k];
                if (any) near(wider(piece, rounding));
            }
            rest.lower[k] = std::max(rest.lower[k], halo.box.lower[k]);
            rest.upper[k] = std::min(rest.upper[k], halo.box.upper[k]);
        }
    };
    if (for_images(tile.box, home, distance, outside_halo)) return;
    // Too many images: one box stands for all of space.
    visit(all_space);
}

}  // namespace votess::blocks

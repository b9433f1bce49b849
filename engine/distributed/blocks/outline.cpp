#include "distributed/blocks/outline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/arithmetic.hpp"
#include "core/huge_pages.hpp"

namespace votess::blocks {
namespace {

constexpr std::size_t max_tile_seeds = 512, mean_cell_seeds = 420;
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

std::size_t longest_side(const Vector& sides) {
    return static_cast<std::size_t>(std::ranges::max_element(sides) - sides.begin());
}

// Cells of equal size, in the order of Morton: halves of the longest side, then halves of these.
class Grid {
public:
    // seeds: the number of places in the box.
    Grid(const Box& box, std::size_t seeds) : lower_(box.lower) {
        Vector side;
        for (std::size_t k = 0; k < 3; ++k) side[k] = box.upper[k] - box.lower[k];
        const Vector whole = side;
        std::vector<std::size_t> axes;
        std::array<std::size_t, 3> bits{};
        while (seeds > mean_cell_seeds << axes.size()) {
            const std::size_t axis = longest_side(side);
            if (!(side[axis] > 0)) break;
            side[axis] /= 2;
            ++bits[axis];
            axes.push_back(axis);
        }
        cells_ = std::size_t{1} << axes.size();
        for (std::size_t k = 0; k < 3; ++k) {
            part_[k].assign(std::size_t{1} << bits[k], 0);
            scale_[k] = static_cast<double>(part_[k].size()) / whole[k];
            if (!std::isfinite(scale_[k])) scale_[k] = 0;
        }
        std::array<std::size_t, 3> left = bits;
        for (std::size_t level = 0; level < axes.size(); ++level) {
            const std::size_t axis = axes[level], bit = --left[axis];
            for (std::size_t i = 0; i < part_[axis].size(); ++i)
                part_[axis][i] |= static_cast<std::uint32_t>((i >> bit & 1) << (axes.size() - 1 - level));
        }
    }

    [[nodiscard]] std::size_t cells() const { return cells_; }
    // Returns the number of the cell. Places that are equal are in one cell.
    [[nodiscard]] std::uint32_t cell_of(const exact::Point& place) const {
        std::uint32_t cell = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto i = static_cast<std::size_t>((place[k] - lower_[k]) * scale_[k]);
            cell |= part_[k][std::min(i, part_[k].size() - 1)];
        }
        return cell;
    }

private:
    exact::Point lower_;
    Vector scale_{};
    std::array<std::vector<std::uint32_t>, 3> part_;  // of a cell's number, by its place along the axis
    std::size_t cells_ = 1;
};

// Splits seeds at about the median of the longest side until tiles are small enough.
class Tiler {
public:
    Tiler(const std::vector<exact::Point>& places, std::span<const double> weights)
        : places_(places), weights_(weights) {}

    // Appends the tiles of some seeds and the numbers of seeds in them. Puts the seeds in their order.
    void make_tiles(std::span<std::uint32_t> numbers, std::vector<Tile>& tiles, std::vector<std::size_t>& sizes) {
        seeds_.clear();
        for (const std::uint32_t i : numbers) seeds_.push_back({places_[i], i});
        split({0, seeds_.size()}, tiles, sizes);
        for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = seeds_[k].number;
    }

private:
    struct Seed {
        exact::Point x;
        std::uint32_t number;
    };
    struct Range {
        std::size_t begin, end;
    };

    void split(Range range, std::vector<Tile>& tiles, std::vector<std::size_t>& sizes) {
        const std::size_t count = range.end - range.begin;
        const Box box = box_of(range);
        if (const std::size_t middle = count > max_tile_seeds ? divide(range, box) : range.begin;
            middle > range.begin) {
            split({range.begin, middle}, tiles, sizes);
            split({middle, range.end}, tiles, sizes);
            return;
        }
        double volume = 1, dimensions = 0, largest = weights_.empty() ? 0 : -infinity;
        for (std::size_t k = 0; k < 3; ++k)
            if (const double side = box.upper[k] - box.lower[k]; side > 0) volume *= side, ++dimensions;
        for (std::size_t k = range.begin; k < range.end && !weights_.empty(); ++k)
            largest = std::max(largest, weights_[seeds_[k].number]);
        const double width =
            dimensions > 0 ? halo_spacings * std::pow(volume / static_cast<double>(count), 1 / dimensions) : 0;
        tiles.push_back({box, width, largest});
        sizes.push_back(count);
    }

    [[nodiscard]] Box box_of(Range range) const {
        Box box = empty_box;
        for (std::size_t k = range.begin; k < range.end; ++k) include(box, seeds_[k].x);
        return box;
    }

    // Returns where the second half begins, or the range's begin when all seeds are at one place. Seeds at one place
    // stay together, so that a halo has all or none of them.
    std::size_t divide(Range range, const Box& box) {
        const std::size_t axis =
            longest_side({box.upper[0] - box.lower[0], box.upper[1] - box.lower[1], box.upper[2] - box.lower[2]});
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

    const std::vector<exact::Point>& places_;
    std::span<const double> weights_;
    std::vector<Seed> seeds_;
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

// A grid makes tiles in a few passes. Cells with too many seeds are split.
TiledSeeds tile_seeds(const std::vector<exact::Point>& places, std::span<const double> weights, ThreadPool& pool) {
    constexpr std::size_t task_seeds = 16384;
    TiledSeeds tiled;
    tiled.begin.assign(1, 0);
    tiled.outline = outline_of({});
    const std::size_t count = places.size();
    if (count == 0) return tiled;
    Box box = empty_box;
    for (const exact::Point& place : places) include(box, place);
    const Grid grid(box, count);
    std::vector<std::uint32_t> cell_of;
    resize_in_huge_pages(cell_of, count);
    pool.run(ceil_div(count, task_seeds), [&](std::size_t task, unsigned) {
        for (std::size_t i = task * task_seeds; i < std::min(count, (task + 1) * task_seeds); ++i)
            cell_of[i] = grid.cell_of(places[i]);
    });
    std::vector<std::size_t> ends(grid.cells() + 1);  // at first where the seeds of a cell begin
    for (const std::uint32_t cell : cell_of) ++ends[cell + 1];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    resize_in_huge_pages(tiled.order, count);
    for (std::size_t i = 0; i < count; ++i) tiled.order[ends[cell_of[i]]++] = static_cast<std::uint32_t>(i);

    struct Tiles {
        std::vector<Tile> tiles;
        std::vector<std::size_t> sizes;
    };
    const std::size_t task_cells = ceil_div(grid.cells(), 16 * std::size_t{pool.size()});
    std::vector<Tiles> of_task(ceil_div(grid.cells(), task_cells));
    pool.run(of_task.size(), [&](std::size_t task, unsigned) {
        Tiler tiler(places, weights);
        for (std::size_t c = task * task_cells; c < std::min(grid.cells(), (task + 1) * task_cells); ++c) {
            const std::size_t begin = c == 0 ? 0 : ends[c - 1];
            if (begin == ends[c]) continue;
            tiler.make_tiles(std::span(tiled.order).subspan(begin, ends[c] - begin), of_task[task].tiles,
                             of_task[task].sizes);
        }
    });
    std::vector<Tile> tiles;
    for (const Tiles& some : of_task) {
        tiles.insert(tiles.end(), some.tiles.begin(), some.tiles.end());
        for (const std::size_t size : some.sizes) tiled.begin.push_back(tiled.begin.back() + size);
    }
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

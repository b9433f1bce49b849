#include "blocks/outline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace votess::blocks {
namespace {

constexpr std::size_t tile_seeds_at_most = 512;
constexpr double layer_spacings = 2.5;  // nearly all cells at a border reach less far
constexpr std::size_t most_images = 512;
constexpr double infinity = std::numeric_limits<double>::infinity();

using Vector = std::array<double, 3>;

Box no_box() {
    return {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
}

void include(Box& box, const Box& other) {
    for (std::size_t k = 0; k < 3; ++k) {
        box.lower[k] = std::min(box.lower[k], other.lower[k]);
        box.upper[k] = std::max(box.upper[k], other.upper[k]);
    }
}

Box moved(const Box& box, const Vector& by) {
    Box result;
    for (std::size_t k = 0; k < 3; ++k) result.lower[k] = box.lower[k] + by[k], result.upper[k] = box.upper[k] + by[k];
    return result;
}

Box wider(const Box& box, double by) {
    return moved({{box.lower[0] - 2 * by, box.lower[1] - 2 * by, box.lower[2] - 2 * by}, box.upper}, {by, by, by});
}

double distance_squared(const Box& a, const Box& b) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double gap = std::max({0.0, a.lower[k] - b.upper[k], b.lower[k] - a.upper[k]});
        sum += gap * gap;
    }
    return sum;
}

// Splits seeds at the median of the longest side until tiles are small enough.
struct Tiler {
    const std::vector<exact::Point>& places;
    std::span<const double> weights;
    TiledSeeds& out;

    void split(std::size_t begin, std::size_t end) {
        Tile tile{no_box(), 0, -infinity};
        for (std::size_t k = begin; k < end; ++k) {
            const exact::Point& x = places[out.order[k]];
            include(tile.box, {x, x});
            tile.largest_weight = std::max(tile.largest_weight, weights.empty() ? 0 : weights[out.order[k]]);
        }
        const std::size_t count = end - begin;
        std::size_t axis = 0;
        std::array<double, 3> sides;
        for (std::size_t k = 0; k < 3; ++k) {
            sides[k] = tile.box.upper[k] - tile.box.lower[k];
            if (sides[k] > sides[axis]) axis = k;
        }
        if (count > tile_seeds_at_most) {
            const std::size_t middle = divide(begin, end, axis);
            if (middle > begin) {
                split(begin, middle);
                return split(middle, end);
            }
        }
        add(tile, sides, begin, end);
    }

private:
    // Seeds at one place stay together, so that who is given one is given the others too. Returns where the second half
    // begins; `begin` where there is but one place.
    std::size_t divide(std::size_t begin, std::size_t end, std::size_t axis) {
        const auto at = [&](std::size_t k) { return out.order.begin() + static_cast<std::ptrdiff_t>(k); };
        const auto middle = at(begin + (end - begin) / 2);
        std::nth_element(at(begin), middle, at(end), [&](std::uint32_t i, std::uint32_t j) {
            const double x = places[i][axis], y = places[j][axis];
            return x != y ? x < y : places[i] < places[j];
        });
        const exact::Point& first = places[*middle];
        const auto moved = std::partition(at(begin), middle, [&](std::uint32_t i) { return places[i] != first; });
        return static_cast<std::size_t>(moved - out.order.begin());
    }

    void add(Tile& tile, const std::array<double, 3>& sides, std::size_t begin, std::size_t end) {
        const auto count = static_cast<double>(end - begin);
        tile.width = layer_spacings * std::cbrt(sides[0] * sides[1] * sides[2] / count);
        out.outline.tiles.push_back(tile);
        out.begin.push_back(end);
    }
};

}  // namespace

TiledSeeds tile_seeds(const std::vector<exact::Point>& places, std::span<const double> weights) {
    TiledSeeds tiled;
    tiled.order.resize(places.size());
    std::iota(tiled.order.begin(), tiled.order.end(), 0u);
    tiled.begin.assign(1, 0);
    if (!places.empty()) Tiler{places, weights, tiled}.split(0, places.size());
    tiled.outline = outline_of(std::move(tiled.outline.tiles));
    return tiled;
}

Outline outline_of(std::vector<Tile> tiles) {
    Outline outline{no_box(), -infinity, std::move(tiles)};
    for (const Tile& tile : outline.tiles) {
        include(outline.box, tile.box);
        outline.largest_weight = std::max(outline.largest_weight, tile.largest_weight);
    }
    return outline;
}

Outline summary_of(const Outline& outline) {
    if (outline.tiles.empty()) return outline;
    return outline_of({{outline.box, 0, outline.largest_weight}});
}

Nearness::Nearness(const Domain& domain) : domain_(domain) {
    double size = largest_coordinate(domain.box);
    for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t k = 0; k < 3; ++k) size = std::max(size, std::abs(domain.vector[j][k]));
    if (domain.is_periodic()) rounding_ = 0x1p-48 * size;
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
    const double reach = (distance + std::sqrt(half)) * (1 + 1e-9) + 4 * rounding_;
    const ShiftRange range = shifts_around(domain_, box, middle, reach);
    double images = 1;
    for (std::size_t j = 0; j < 3; ++j) images *= static_cast<double>(range.most[j]) - range.least[j] + 1;
    if (!(images <= most_images)) return false;
    const double near = distance + 4 * rounding_;
    ShiftRange one = range;
    for (one.least[0] = range.least[0]; one.least[0] <= range.most[0]; ++one.least[0])
        for (one.least[1] = range.least[1]; one.least[1] <= range.most[1]; ++one.least[1])
            for (one.least[2] = range.least[2]; one.least[2] <= range.most[2]; ++one.least[2]) {
                one.most = one.least;
                const Vector by = domain_.translation(only_shift(domain_, one));
                if (distance_squared(moved(box, by), home) <= near * near) task(by);
            }
    return true;
}

Nearness::Layer Nearness::layer_of(const Tile& tile, const Box& known) const {
    Layer layer{wider(known, tile.width), {}};
    (void)for_images(tile.box, layer.box, 0, [&](const Vector& by) { layer.by.push_back(by); });
    return layer;
}

bool Nearness::holds(const Layer& layer, const exact::Point& place) {
    return std::ranges::any_of(layer.by, [&](const Vector& by) {
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = place[k] + by[k];
            if (!(x >= layer.box.lower[k] && x <= layer.box.upper[k])) return false;
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
    const Layer layer = layer_of(tile, known);
    const auto near = [&](const Box& piece) {
        if (distance_squared(piece, home) <= distance * distance) visit(piece);
    };
    const auto without_layer = [&](const Vector& by) {
        // What is left of the image is cut off side by side; the pieces are a little wider than rounding is.
        Box rest = moved(tile.box, by);
        if (layer.by.empty() || distance_squared(rest, layer.box) > 0) return near(wider(rest, rounding_));
        for (std::size_t k = 0; k < 3; ++k) {
            for (const bool upper : {false, true}) {
                Box piece = rest;
                if (upper)
                    piece.lower[k] = std::max(piece.lower[k], layer.box.upper[k]);
                else
                    piece.upper[k] = std::min(piece.upper[k], layer.box.lower[k]);
                const bool any = upper ? rest.upper[k] > layer.box.upper[k] : rest.lower[k] < layer.box.lower[k];
                if (any) near(wider(piece, rounding_));
            }
            rest.lower[k] = std::max(rest.lower[k], layer.box.lower[k]);
            rest.upper[k] = std::min(rest.upper[k], layer.box.upper[k]);
        }
    };
    if (for_images(tile.box, home, distance, without_layer)) return;
    // Too many images to look at: they are taken for one, all of space.
    visit({{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}});
}

}  // namespace votess::blocks

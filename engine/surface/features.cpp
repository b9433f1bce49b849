#include "surface/features.hpp"

#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>
#include <numbers>

#include "core/at.hpp"
#include "core/vector3.hpp"
#include "surface/nearest.hpp"

namespace votess::surface {
namespace {

// A seed stays on a feature if its part holds at least this much of it, in units of the part's size.
constexpr double least_feature = 0.5;

Vector3 place_of(const std::vector<double>& vertices, std::int32_t v) {
    const std::size_t i = 3 * at(v);
    return {vertices[i], vertices[i + 1], vertices[i + 2]};
}

double length_of(const Vector3& v) {
    return length3(v[0], v[1], v[2]);
}

}  // namespace

Features::Features(const solid::MeshArrays& mesh, double sharp) {
    const std::size_t count = mesh.triangles.size() / 3;
    struct HalfEdge {
        std::int32_t low, high;
        std::size_t triangle;
        std::int32_t slot;
        bool ascends;
        auto operator<=>(const HalfEdge&) const = default;
    };
    std::vector<HalfEdge> sides;
    std::vector<Vector3> normals(count);
    for (std::size_t t = 0; t < count; ++t) {
        const std::int32_t* const corner = &mesh.triangles[3 * t];
        const Vector3 a = place_of(mesh.vertices, corner[0]);
        const Vector3 n =
            cross(minus(place_of(mesh.vertices, corner[1]), a), minus(place_of(mesh.vertices, corner[2]), a));
        const double length = length_of(n);
        if (!(length > 0)) continue;
        normals[t] = {n[0] / length, n[1] / length, n[2] / length};
        for (std::int32_t s = 0; s < 3; ++s) {
            const std::int32_t u = corner[s], v = corner[(s + 1) % 3];
            sides.push_back({std::min(u, v), std::max(u, v), t, s, u < v});
        }
    }
    std::ranges::sort(sides);
    const double cosine = std::cos(sharp * std::numbers::pi / 180);
    edge_of_.assign(3 * count, -1);
    // Directions from each vertex along its features: two that go on nearly straight sum to little.
    std::vector<Vector3> ways(mesh.vertices.size() / 3);
    std::vector<std::uint32_t> degrees(ways.size());
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        const HalfEdge &first = sides[begin], *last = &first;
        for (; end < sides.size() && sides[end].low == first.low && sides[end].high == first.high; ++end) {
            last = &sides[end];
            edge_of_[3 * last->triangle + at(last->slot)] = static_cast<std::int32_t>(counts_.size());
        }
        // Two triangles of one orientation run along their edge in opposite directions.
        const double turned = first.ascends == last->ascends ? -1 : 1;
        const bool is_sharp = turned * dot(normals[first.triangle], normals[last->triangle]) < cosine;
        counts_.push_back(static_cast<std::int32_t>(end - begin));
        is_feature_.push_back(end - begin != 2 || is_sharp ? 1 : 0);
        if (is_feature_.back() == 0) continue;
        const Vector3 way = minus(place_of(mesh.vertices, first.high), place_of(mesh.vertices, first.low));
        const double length = length_of(way);
        ++degrees[at(first.low)], ++degrees[at(first.high)];
        if (!(length > 0)) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            ways[at(first.low)][k] += way[k] / length;
            ways[at(first.high)][k] -= way[k] / length;
        }
    }
    const double bend = 2 * std::sin(sharp * std::numbers::pi / 360);
    for (std::size_t v = 0; v < ways.size(); ++v)
        is_corner_.push_back(degrees[v] > 0 && (degrees[v] != 2 || length_of(ways[v]) > bend) ? 1 : 0);
}

void Features::attract(const SurfaceCells& cells, std::vector<std::array<double, 3>>& places) const {
    struct Stretch {
        std::size_t piece;
        Vector3 a, b;
    };
    std::vector<Stretch> stretches;
    std::vector<double> lengths(places.size()), areas(places.size());
    std::vector<Vector3> middles(places.size());
    std::vector<std::int32_t> corners(places.size(), -1);  // the first in each part
    for (std::size_t p = 0; p + 1 < cells.polygon_offsets.size(); ++p) {
        const std::size_t begin = at(cells.polygon_offsets[p]), end = at(cells.polygon_offsets[p + 1]);
        const std::size_t piece = at(cells.polygon_pieces[p]);
        areas[piece] += cells.polygon_areas[p];
        for (std::size_t c = begin; c < end; ++c) {
            const std::int32_t corner = cells.corners[c];
            if (at(corner) < is_corner_.size() && is_corner_[at(corner)] != 0 && corners[piece] < 0)
                corners[piece] = corner;
            if (cells.beyond[c] >= 0) continue;
            const std::int32_t edge = edge_of_[3 * at(cells.polygon_triangles[p]) + at(-1 - cells.beyond[c])];
            if (edge < 0 || is_feature_[at(edge)] == 0) continue;
            const Vector3 a = place_of(cells.vertices, corner);
            const Vector3 b = place_of(cells.vertices, cells.corners[c + 1 == end ? begin : c + 1]);
            const double length = distance(a, b) / counts_[at(edge)];
            stretches.push_back({piece, a, b});
            lengths[piece] += length;
            for (std::size_t k = 0; k < 3; ++k) middles[piece][k] += length * 0.5 * (a[k] + b[k]);
        }
    }
    std::vector<double> least(places.size(), std::numeric_limits<double>::infinity());
    for (const auto& [piece, a, b] : stretches) {
        if (!(lengths[piece] > least_feature * std::sqrt(areas[piece]))) continue;
        const Vector3& sum = middles[piece];
        const double length = lengths[piece];
        const Vector3 middle{sum[0] / length, sum[1] / length, sum[2] / length};
        const Vector3 foot = nearest_on_segment(middle, a, b);
        if (const double far = distance(foot, middle); far < least[piece]) least[piece] = far, places[piece] = foot;
    }
    for (std::size_t piece = 0; piece < places.size(); ++piece)
        if (corners[piece] >= 0) places[piece] = place_of(cells.vertices, corners[piece]);
}

}  // namespace votess::surface

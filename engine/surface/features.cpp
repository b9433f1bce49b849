#include "surface/features.hpp"

#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/at.hpp"
#include "core/vector3.hpp"
#include "surface/nearest.hpp"

namespace votess::surface {
namespace {

// A seed stays on a feature if its part holds at least this much of it, in units of the part's size.
constexpr double least_feature = 0.5;
// A vertex is on a feature if it is no farther from it, in units of its part's size and of the surface's.
constexpr double of_part = 1e-9, of_surface = 4e-15;

Vector3 place_of(const std::vector<double>& vertices, std::int32_t v) {
    const std::size_t i = 3 * at(v);
    return {vertices[i], vertices[i + 1], vertices[i + 2]};
}

double length_of(const Vector3& v) {
    return length3(v[0], v[1], v[2]);
}

}  // namespace

Features::Features(const solid::MeshArrays& mesh, double sharp) {
    triangles_ = mesh.triangles;
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
    std::vector<std::uint8_t> at_border(ways.size());
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
        if (counts_.back() == 1) at_border[at(first.low)] = at_border[at(first.high)] = 1;
        if (!(length > 0)) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            ways[at(first.low)][k] += way[k] / length;
            ways[at(first.high)][k] -= way[k] / length;
        }
    }
    const double bend = 2 * std::sin(sharp * std::numbers::pi / 360);
    for (std::size_t v = 0; v < ways.size(); ++v)
        corners_.push_back(degrees[v] == 0 || (degrees[v] == 2 && length_of(ways[v]) <= bend) ? Corner::none
                           : at_border[v] != 0                                                ? Corner::of_border
                                                                                              : Corner::sharp);
}

std::int32_t Features::corner_at(const SurfaceCells& cells, std::size_t polygon, std::size_t c) const {
    const std::int32_t at_place = cells.corners[c];
    if (at(at_place) < corners_.size()) return corners_[at(at_place)] == Corner::none ? -1 : at_place;
    // A bisector through a corner has a vertex of its own there.
    for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t vertex = triangles_[3 * at(cells.polygon_triangles[polygon]) + k];
        if (corners_[at(vertex)] != Corner::none &&
            distance(place_of(cells.vertices, vertex), place_of(cells.vertices, at_place)) <= of_surface)
            return vertex;
    }
    return -1;
}

template <class Use>
void Features::each_stretch(const SurfaceCells& cells, const Use& use) const {
    for (std::size_t p = 0; p + 1 < cells.polygon_offsets.size(); ++p) {
        const std::size_t begin = at(cells.polygon_offsets[p]), end = at(cells.polygon_offsets[p + 1]);
        for (std::size_t c = begin; c < end; ++c) {
            if (cells.beyond[c] >= 0) continue;
            const std::int32_t edge = edge_of_[3 * at(cells.polygon_triangles[p]) + at(-1 - cells.beyond[c])];
            if (edge >= 0 && is_feature_[at(edge)] != 0)
                use(at(cells.polygon_pieces[p]), cells.corners[c], cells.corners[c + 1 == end ? begin : c + 1],
                    counts_[at(edge)]);
        }
    }
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
    std::vector<std::uint8_t> is_taken(corners_.size());
    for (std::size_t p = 0; p + 1 < cells.polygon_offsets.size(); ++p) {
        const std::size_t piece = at(cells.polygon_pieces[p]);
        areas[piece] += cells.polygon_areas[p];
        for (std::int64_t c = cells.polygon_offsets[p]; c < cells.polygon_offsets[p + 1]; ++c) {
            const std::int32_t corner = corner_at(cells, p, at(c));
            if (corners[piece] >= 0 || corner < 0 || is_taken[at(corner)] != 0) continue;
            corners[piece] = corner;
            is_taken[at(corner)] = 1;
        }
    }
    each_stretch(cells, [&](std::size_t piece, std::int32_t from, std::int32_t to, std::int32_t triangles) {
        const Vector3 a = place_of(cells.vertices, from), b = place_of(cells.vertices, to);
        const double length = distance(a, b) / triangles;
        stretches.push_back({piece, a, b});
        lengths[piece] += length;
        for (std::size_t k = 0; k < 3; ++k) middles[piece][k] += length * 0.5 * (a[k] + b[k]);
    });
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

std::vector<Features::Gap> Features::gaps(const SurfaceCells& cells, const std::vector<double>& vertices) const {
    std::vector<double> areas(vertices.size() / 3);
    std::vector<std::pair<std::int32_t, std::size_t>> held;  // a corner, and a part with it
    for (std::size_t p = 0; p + 1 < cells.polygon_offsets.size(); ++p) {
        areas[at(cells.polygon_pieces[p])] += cells.polygon_areas[p];
        for (std::int64_t c = cells.polygon_offsets[p]; c < cells.polygon_offsets[p + 1]; ++c)
            if (const std::int32_t corner = corner_at(cells, p, at(c)); corner >= 0)
                held.emplace_back(corner, at(cells.polygon_pieces[p]));
    }
    const auto vertex = [&](std::size_t piece) { return place_of(vertices, static_cast<std::int32_t>(piece)); };
    std::vector<Gap> gaps;
    std::ranges::sort(held);
    for (std::size_t begin = 0, end = 0; begin < held.size(); begin = end) {
        const auto [corner, piece] = held[begin];
        const Vector3 place = place_of(cells.vertices, corner);
        bool is_vertex = false;
        for (; end < held.size() && held[end].first == corner; ++end) is_vertex |= vertex(held[end].second) == place;
        if (!is_vertex && (corners_[at(corner)] == Corner::of_border ||
                           distance(place, vertex(piece)) > least_feature * std::sqrt(areas[piece])))
            gaps.push_back({piece, place, false, true, corners_[at(corner)] == Corner::of_border});
    }

    std::vector<Stretch> stretches;
    each_stretch(cells, [&](std::size_t piece, std::int32_t from, std::int32_t to, std::int32_t triangles) {
        stretches.push_back({piece, std::min(from, to), std::max(from, to), triangles == 1});
    });
    std::ranges::sort(stretches);
    for (std::size_t begin = 0, end = 0; begin < stretches.size(); begin = end) {
        const std::size_t piece = stretches[begin].piece;
        while (end < stretches.size() && stretches[end].piece == piece) ++end;
        add_gaps(std::span(stretches).subspan(begin, end - begin), cells, vertex(piece),
                 of_surface + of_part * std::sqrt(areas[piece]), gaps);
    }
    return gaps;
}

// Stretches that share ends are one line.
void Features::add_gaps(std::span<const Stretch> stretches, const SurfaceCells& cells, const Vector3& vertex,
                        double enough, std::vector<Gap>& gaps) {
    std::vector<std::int32_t> ends;
    for (const Stretch& stretch : stretches) ends.insert(ends.end(), {stretch.from, stretch.to});
    std::ranges::sort(ends);
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    std::vector<std::size_t> line(ends.size());
    std::iota(line.begin(), line.end(), std::size_t{0});
    const auto line_of = [&](std::int32_t end) {
        auto i = static_cast<std::size_t>(std::ranges::lower_bound(ends, end) - ends.begin());
        while (line[i] != i) i = line[i] = line[line[i]];
        return i;
    };
    for (const Stretch& stretch : stretches) line[line_of(stretch.from)] = line_of(stretch.to);
    struct Line {
        double far = std::numeric_limits<double>::infinity();
        Vector3 nearest{}, way{};  // to the vertex, and the direction there
        bool has_border = false;
    };
    std::vector<Line> lines(ends.size());
    for (const Stretch& stretch : stretches) {
        Line& of = lines[line_of(stretch.from)];
        of.has_border |= stretch.is_border;
        const Vector3 a = place_of(cells.vertices, stretch.from), b = place_of(cells.vertices, stretch.to);
        const Vector3 place = nearest_on_segment(vertex, a, b);
        if (!(distance(place, vertex) < of.far)) continue;
        of.far = distance(place, vertex), of.nearest = place;
        if (const double length = distance(a, b); length > 0) of.way = along({0, 0, 0}, minus(b, a), 1 / length);
    }
    const auto own = std::ranges::min_element(lines, {}, &Line::far);
    for (const Line& of : lines) {
        if (!(of.far > enough) || std::isinf(of.far)) continue;
        const bool is_near = own->far > enough;
        if (is_near ? &of != &*own && !of.has_border : !of.has_border) continue;
        // In a wedge the place is as far from the tip as the vertex is. Places not quite opposite to each other would
        // each be nearest to a stretch of the other's side.
        Vector3 goal = of.nearest;
        if (!is_near) {
            const double turn = dot(own->way, minus(vertex, of.nearest)) / of.far;
            const double sine = std::clamp(dot(own->way, of.way) < 0 ? -turn : turn, -1.0, 1.0);
            goal = along(goal, of.way, of.far * sine / (1 + std::sqrt(1 - sine * sine)));
        }
        Vector3 place = of.nearest;
        double least = std::numeric_limits<double>::infinity();
        for (const Stretch& stretch : stretches) {
            if (&lines[line_of(stretch.from)] != &of) continue;
            const Vector3 x =
                nearest_on_segment(goal, place_of(cells.vertices, stretch.from), place_of(cells.vertices, stretch.to));
            if (distance(x, goal) < least) least = distance(x, goal), place = x;
        }
        gaps.push_back({stretches.front().piece, place, is_near && &of == &*own, false, of.has_border});
    }
}

}  // namespace votess::surface

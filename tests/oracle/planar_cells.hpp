// Cells of the plane, by half-planes clipped in rational numbers.
#pragma once

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>
#include <votess/votess.hpp>

#include "support/random.hpp"

namespace test {

using PlanarVector = std::array<mpq_class, 2>;

struct PlanarSet {
    std::vector<double> points, weights;
    votess::Options options;  // the domain
};

// Neighbor and its shift. Walls have no shift.
using PlanarLabel = std::tuple<std::int32_t, int, int>;

// The sides of a large square have these ids, in a plane without end.
inline constexpr PlanarLabel at_infinity{-1000, 0, 0};

struct PlanarCell {
    std::map<PlanarLabel, double> lengths;  // of edges of positive length
    mpq_class area;
    PlanarVector centroid;  // times area
    std::size_t corners = 0;
};

// n.x <= h
struct HalfPlane {
    PlanarVector n;
    mpq_class h;
    PlanarLabel label;
};

// Returns the polygon that the half-planes leave of a large square, each edge with the label of its half-plane.
inline PlanarCell clip_polygon(const std::vector<HalfPlane>& planes) {
    struct Corner {
        PlanarVector x;
        PlanarLabel label;  // of the edge that begins here
    };
    const mpq_class far = 1 << 30;
    std::vector<Corner> polygon{
        {{-far, -far}, at_infinity}, {{far, -far}, at_infinity}, {{far, far}, at_infinity}, {{-far, far}, at_infinity}};
    for (const HalfPlane& plane : planes) {
        std::vector<Corner> kept;
        for (std::size_t k = 0; k < polygon.size(); ++k) {
            const Corner &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
            const mpq_class above_a = plane.n[0] * a.x[0] + plane.n[1] * a.x[1] - plane.h;
            const mpq_class above_b = plane.n[0] * b.x[0] + plane.n[1] * b.x[1] - plane.h;
            if (above_a <= 0) kept.push_back(a);
            if ((above_a < 0 && above_b > 0) || (above_a > 0 && above_b < 0)) {
                const mpq_class t = above_a / (above_a - above_b);
                Corner cut{{a.x[0] + t * (b.x[0] - a.x[0]), a.x[1] + t * (b.x[1] - a.x[1])}, a.label};
                if (above_a < 0) cut.label = plane.label;
                kept.push_back(cut);
            } else if (above_a == 0 && above_b > 0 && !kept.empty()) {
                kept.back().label = plane.label;
            }
        }
        polygon = kept;
    }
    PlanarCell cell;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const PlanarVector &a = polygon[k].x, &b = polygon[(k + 1) % polygon.size()].x;
        if (a == b) continue;
        ++cell.corners;
        const mpq_class dx = b[0] - a[0], dy = b[1] - a[1], cross = a[0] * b[1] - a[1] * b[0];
        cell.lengths[polygon[k].label] += std::hypot(dx.get_d(), dy.get_d());
        cell.area += cross / 2;
        for (std::size_t d = 0; d < 2; ++d) cell.centroid[d] += cross * (a[d] + b[d]) / 6;
    }
    if (cell.area == 0) cell = {};
    return cell;
}

// Returns whether another seed at the place of seed i, heavier or of lower index, keeps the cell.
inline bool is_duplicate(const PlanarSet& set, std::size_t i) {
    const auto weight = [&](std::size_t j) { return set.weights.empty() ? 0 : set.weights[j]; };
    for (std::size_t j = 0; 2 * j < set.points.size(); ++j)
        if (j != i && set.points[2 * j] == set.points[2 * i] && set.points[2 * j + 1] == set.points[2 * i + 1] &&
            (weight(j) > weight(i) || (weight(j) == weight(i) && j < i)))
            return true;
    return false;
}

// The seeds of a periodic domain lie inside it.
inline PlanarCell exact_planar_cell(const PlanarSet& set, std::size_t i) {
    const votess::Options& o = set.options;
    std::array<PlanarVector, 2> edges;
    std::array<bool, 2> periodic{};
    std::vector<HalfPlane> planes;
    if (o.cell) {
        for (std::size_t k = 0; k < 2; ++k) {
            edges[0][k] = o.cell->a[k], edges[1][k] = o.cell->b[k];
            periodic[k] = o.cell->periodic[k];
        }
    } else {
        for (std::size_t k = 0; k < 2; ++k) {
            const double lower = o.box->lower[k], upper = o.box->upper[k];
            periodic[k] = o.periodic[k];
            if (periodic[k]) edges[k][k] = mpq_class(upper) - mpq_class(lower);
            const auto wall = -1 - 2 * static_cast<std::int32_t>(k);
            HalfPlane below{{}, {}, {wall, 0, 0}}, above{{}, {}, {wall - 1, 0, 0}};
            below.n[k] = -1, above.n[k] = 1;
            if (!periodic[k] && std::isfinite(lower)) planes.push_back({below.n, -mpq_class(lower), below.label});
            if (!periodic[k] && std::isfinite(upper)) planes.push_back({above.n, upper, above.label});
        }
    }
    for (std::size_t w = 0; w < o.walls.size(); ++w)
        planes.push_back(
            {{o.walls[w].normal[0], o.walls[w].normal[1]}, o.walls[w].offset, {-7 - static_cast<int>(w), 0, 0}});
    const auto weight = [&](std::size_t j) { return set.weights.empty() ? mpq_class(0) : mpq_class(set.weights[j]); };
    if (is_duplicate(set, i)) return {};
    const PlanarVector x{set.points[2 * i], set.points[2 * i + 1]};
    const int reach = 2;
    for (std::size_t j = 0; 2 * j < set.points.size(); ++j) {
        if (is_duplicate(set, j)) continue;
        for (int s = periodic[0] ? -reach : 0; s <= (periodic[0] ? reach : 0); ++s)
            for (int t = periodic[1] ? -reach : 0; t <= (periodic[1] ? reach : 0); ++t) {
                if (i == j && s == 0 && t == 0) continue;
                PlanarVector y{set.points[2 * j], set.points[2 * j + 1]};
                for (std::size_t k = 0; k < 2; ++k) y[k] += s * edges[0][k] + t * edges[1][k];
                const PlanarVector n{y[0] - x[0], y[1] - x[1]};
                const mpq_class h = (y[0] * y[0] + y[1] * y[1] - x[0] * x[0] - x[1] * x[1] + weight(i) - weight(j)) / 2;
                planes.push_back({n, h, {static_cast<std::int32_t>(j), s, t}});
            }
    }
    // In power diagrams bisectors may be one line. The edge is that of the farthest seed, whose power is least beyond.
    // A wall keeps its edge.
    const auto length = [](const HalfPlane& plane) {
        return std::get<0>(plane.label) < 0 ? mpq_class(1 << 30)
                                            : mpq_class(plane.n[0] * plane.n[0] + plane.n[1] * plane.n[1]);
    };
    std::ranges::stable_sort(planes, [&](const auto& a, const auto& b) { return length(a) > length(b); });
    return clip_polygon(planes);
}

// Returns a small set, some on a lattice, some with weights, in a box, an oblique cell or between walls.
inline PlanarSet random_planar_set(std::uint64_t number) {
    Random random(number);
    PlanarSet set;
    const bool lattice = number % 3 == 0;
    const std::size_t n = 1 + random.below(24);
    const double size = 16;
    for (std::size_t i = 0; i < 2 * n; ++i)
        set.points.push_back(lattice ? static_cast<double>(random.below(8)) : size * random.uniform());
    if (number % 4 == 1)
        for (std::size_t i = 0; i < n; ++i) set.weights.push_back(std::floor(4 * random.uniform()));
    votess::Options& o = set.options;
    const bool periodic[2] = {random.chance(0.5), random.chance(0.5)};
    switch (number % 5) {
        case 0:  // oblique
            o.cell = votess::TriclinicBox{
                {}, {size, 0, 0}, {random.chance(0.5) ? 5.0 : -7.0, size, 0}, {}, {true, true, true}};
            // The points lie inside: their parts of the edges are coordinates over 16.
            for (std::size_t i = 0; i < n; ++i) set.points[2 * i] += set.points[2 * i + 1] / size * o.cell->b[0];
            break;
        case 1:  // walls
            o.box = votess::Box{{-1, -1, 0}, {size + 1, size + 1, 0}};
            o.outside = votess::Outside::drop;
            o.walls = {{{1, 1, 0}, 28}, {{-1, 2, 0}, 24.5}, {{-1, -1, 0}, 0}};
            for (std::size_t i = 0; i < n; ++i) {  // inside all of them
                set.points[2 * i] = 0.75 * set.points[2 * i] + 0.5;
                set.points[2 * i + 1] = 0.5 * set.points[2 * i + 1] + 0.5;
            }
            break;
        default:
            o.box = votess::Box{{0, 0, 0}, {size, size, 0}};
            o.periodic = {periodic[0], periodic[1], false};
    }
    return set;
}

}  // namespace test

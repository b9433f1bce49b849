// Cells of the plane, against half-planes clipped in rational numbers.
#include <doctest/doctest.h>
#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "support/check.hpp"
#include "support/random.hpp"
#include "support/text.hpp"
#include "votess/votess.hpp"

namespace {

using Vector = std::array<mpq_class, 2>;

struct PlanarSet {
    std::vector<double> points, weights;
    votess::Options options;  // the domain
};

// Neighbor and its shift. Walls have no shift.
using PlanarLabel = std::tuple<std::int32_t, int, int>;

struct PlanarCell {
    std::map<PlanarLabel, double> lengths;  // of edges of positive length
    mpq_class area;
    Vector centroid;  // times area
    std::size_t corners = 0;
};

// n.x <= h
struct HalfPlane {
    Vector n;
    mpq_class h;
    PlanarLabel label;
};

// Returns the polygon that the half-planes leave of a large square, each edge with the label of its half-plane.
PlanarCell clip_polygon(const std::vector<HalfPlane>& planes) {
    struct Corner {
        Vector x;
        PlanarLabel label;  // of the edge that begins here
    };
    const mpq_class far = 1 << 30;
    const PlanarLabel none{-1000, 0, 0};
    std::vector<Corner> polygon{{{-far, -far}, none}, {{far, -far}, none}, {{far, far}, none}, {{-far, far}, none}};
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
        const Vector &a = polygon[k].x, &b = polygon[(k + 1) % polygon.size()].x;
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
bool is_duplicate(const PlanarSet& set, std::size_t i) {
    const auto weight = [&](std::size_t j) { return set.weights.empty() ? 0 : set.weights[j]; };
    for (std::size_t j = 0; 2 * j < set.points.size(); ++j)
        if (j != i && set.points[2 * j] == set.points[2 * i] && set.points[2 * j + 1] == set.points[2 * i + 1] &&
            (weight(j) > weight(i) || (weight(j) == weight(i) && j < i)))
            return true;
    return false;
}

// The seeds of a periodic domain lie inside it.
PlanarCell exact_cell(const PlanarSet& set, std::size_t i) {
    const votess::Options& o = set.options;
    std::array<Vector, 2> edges;
    std::array<bool, 2> periodic{};
    std::vector<HalfPlane> planes;
    if (o.cell) {
        for (std::size_t k = 0; k < 2; ++k) {
            edges[0][k] = o.cell->a[k], edges[1][k] = o.cell->b[k];
            periodic[k] = o.cell->periodic[k];
        }
    } else {
        for (std::size_t k = 0; k < 2; ++k) {
            edges[k][k] = mpq_class(o.box->upper[k]) - mpq_class(o.box->lower[k]);
            periodic[k] = o.periodic[k];
            if (periodic[k]) continue;
            const auto wall = -1 - 2 * static_cast<std::int32_t>(k);
            HalfPlane lower{{}, -mpq_class(o.box->lower[k]), {wall, 0, 0}},
                upper{{}, o.box->upper[k], {wall - 1, 0, 0}};
            lower.n[k] = -1, upper.n[k] = 1;
            planes.push_back(lower);
            planes.push_back(upper);
        }
    }
    for (std::size_t w = 0; w < o.walls.size(); ++w)
        planes.push_back(
            {{o.walls[w].normal[0], o.walls[w].normal[1]}, o.walls[w].offset, {-7 - static_cast<int>(w), 0, 0}});
    const auto weight = [&](std::size_t j) { return set.weights.empty() ? mpq_class(0) : mpq_class(set.weights[j]); };
    if (is_duplicate(set, i)) return {};
    const Vector x{set.points[2 * i], set.points[2 * i + 1]};
    const int reach = 2;
    for (std::size_t j = 0; 2 * j < set.points.size(); ++j) {
        if (is_duplicate(set, j)) continue;
        for (int s = periodic[0] ? -reach : 0; s <= (periodic[0] ? reach : 0); ++s)
            for (int t = periodic[1] ? -reach : 0; t <= (periodic[1] ? reach : 0); ++t) {
                if (i == j && s == 0 && t == 0) continue;
                Vector y{set.points[2 * j], set.points[2 * j + 1]};
                for (std::size_t k = 0; k < 2; ++k) y[k] += s * edges[0][k] + t * edges[1][k];
                const Vector n{y[0] - x[0], y[1] - x[1]};
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

std::string compare_cells(const PlanarSet& set) {
    votess::Options options = set.options;
    options.planar = options.list_walls = true;
    options.weights = set.weights;
    options.device = "cpu";
    options.want = {.neighbors = true,
                    .volumes = true,
                    .centroids = true,
                    .counts = true,
                    .areas = true,
                    .normals = true,
                    .surfaces = true,
                    .radii = true,
                    .vertices = true,
                    .faces = true};
    const votess::Tessellation t = votess::tessellate(std::span<const double>(set.points), options);
    if (!t.planar()) return "the result is not planar";
    for (std::size_t i = 0; i < t.size(); ++i) {
        const PlanarCell cell = exact_cell(set, i);
        const std::string name = "cell " + std::to_string(i) + ": ";
        const auto begin = static_cast<std::size_t>(t.indptr()[i]), end = static_cast<std::size_t>(t.indptr()[i + 1]);
        std::map<PlanarLabel, double> lengths;
        double perimeter = 0;
        const std::span<const std::int32_t> corners = t.cell_vertex_indices().subspan(
            static_cast<std::size_t>(t.cell_vertex_indptr()[i]),
            static_cast<std::size_t>(t.cell_vertex_indptr()[i + 1] - t.cell_vertex_indptr()[i]));
        for (std::size_t e = begin; e < end; ++e) {
            const bool shifted = !t.shifts().empty();
            lengths[{t.indices()[e], shifted ? t.shifts()[2 * e] : 0, shifted ? t.shifts()[2 * e + 1] : 0}] =
                t.face_areas()[e];
            perimeter += t.face_areas()[e];
            // The edge is one of the polygon, and its normal points outwards.
            const auto first = static_cast<std::size_t>(t.face_offsets()[e]);
            if (t.face_offsets()[e + 1] - t.face_offsets()[e] != 2) return name + "an edge has not two corners";
            const std::int32_t from = t.face_vertices()[first], to = t.face_vertices()[first + 1];
            const auto at = std::ranges::find(corners, from);
            if (at == corners.end() ||
                corners[static_cast<std::size_t>(at - corners.begin() + 1) % corners.size()] != to)
                return name + "its polygon lacks an edge";
            const double dx = t.vertices()[2 * to] - t.vertices()[2 * from],
                         dy = t.vertices()[2 * to + 1] - t.vertices()[2 * from + 1];
            const double* normal = &t.face_normals()[2 * e];
            if (std::abs(std::hypot(dx, dy) - t.face_areas()[e]) > 1e-9) return name + "an edge has another length";
            if (t.face_areas()[e] > 1e-6 && normal[0] * dy - normal[1] * dx < 0.999999 * t.face_areas()[e])
                return name + "a normal is wrong";
        }
        if (lengths.size() != cell.lengths.size())
            return name + std::to_string(lengths.size()) + " edges, not " + std::to_string(cell.lengths.size());
        for (const auto& [label, length] : cell.lengths)
            if (!lengths.contains(label) || std::abs(lengths[label] - length) > 1e-9)
                return name + "wrong edge with " + std::to_string(std::get<0>(label));
        if (std::abs(t.volumes()[i] - cell.area.get_d()) > 1e-9) return name + "wrong area";
        if (std::abs(t.surface_areas()[i] - perimeter) > 1e-12 * perimeter) return name + "wrong perimeter";
        if (t.face_counts()[i] != cell.corners || t.edge_counts()[i] != cell.corners ||
            t.vertex_counts()[i] != cell.corners)
            return name + "wrong counts";
        if (corners.size() != cell.corners) return name + "wrong number of corners";
        if (cell.corners == 0) continue;
        double farthest = 0;
        for (std::size_t d = 0; d < 2; ++d)
            if (std::abs(t.centroids()[2 * i + d] - mpq_class(cell.centroid[d] / cell.area).get_d()) > 1e-8)
                return name + "wrong centroid";
        for (const std::int32_t v : corners)
            farthest = std::max(farthest, std::hypot(t.vertices()[2 * v] - set.points[2 * i],
                                                     t.vertices()[2 * v + 1] - set.points[2 * i + 1]));
        if (std::abs(t.security_radii()[i] - 2 * farthest) > 1e-7 * (1 + farthest)) return name + "wrong radius";
    }
    return votess::verify(t, set.points).failure;
}

PlanarSet random_set(std::uint64_t number) {
    test::Random random(number);
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

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("planar: random sets in all domains equal rational half-planes") {
        for (std::uint64_t number = 0; number < test::by_size(30, 12); ++number) {
            CAPTURE(number);
            CHECK(compare_cells(random_set(number)) == "");
        }
    }

    TEST_CASE("planar: far from the origin, tiny and huge") {
        for (const double scale : {0x1p-200, 0x1p-30, 0x1p40, 0x1p300}) {
            CAPTURE(scale);
            PlanarSet set = random_set(7), small = set;
            votess::Options options = set.options;
            options.planar = true;
            const auto t = votess::tessellate(std::span<const double>(set.points), options);
            for (double& x : set.points) x *= scale;
            for (std::size_t k = 0; k < 2; ++k) options.box->lower[k] *= scale, options.box->upper[k] *= scale;
            const auto u = votess::tessellate(std::span<const double>(set.points), options);
            CHECK(std::ranges::equal(t.indices(), u.indices()));
            for (std::size_t i = 0; i < t.size(); ++i)
                CHECK(u.volumes()[i] / scale / scale == doctest::Approx(t.volumes()[i]).epsilon(1e-12));
        }
    }

    TEST_CASE("planar: arrays that are not wanted stay empty, float32 and no points work") {
        const PlanarSet set = random_set(2);
        votess::Options options = set.options;
        options.planar = true;
        options.want = {.neighbors = false, .volumes = false, .surfaces = true};
        const auto t = votess::tessellate(std::span<const double>(set.points), options);
        CHECK(t.surface_areas().size() == t.size());
        CHECK(t.indices().empty());
        CHECK(t.face_areas().empty());
        options.want = {.vertices = true};
        const auto u = votess::tessellate(std::span<const double>(set.points), options);
        CHECK(u.face_offsets().empty());
        CHECK(!u.cell_vertex_indices().empty());
        CHECK(std::ranges::none_of(u.indices(), [](std::int32_t id) { return id < 0; }));
        const std::vector<float> narrow(set.points.begin(), set.points.end());
        CHECK(votess::tessellate(std::span<const float>(narrow), options).size() == t.size());
        CHECK(votess::tessellate(std::span<const double>(), options).size() == 0);
        options.box.reset();
        CHECK(votess::tessellate(std::span<const double>(set.points), options).box().upper[2] == 0);
    }

    TEST_CASE("planar: z and functions of space are refused") {
        votess::Options options;
        options.planar = true;
        const std::vector<double> points{0.5, 0.5, 0.25, 0.75};
        const auto message = [&] {
            try {
                (void)votess::tessellate(std::span<const double>(points), options);
            } catch (const votess::Error& error) {
                return std::string(error.what());
            }
            return std::string();
        };
        CHECK(message() == "");
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        CHECK(test::has(message(), "box has z = 1"));
        options.box->upper[2] = 0;
        options.walls = {{{1, 0, 1}, 2}};
        CHECK(test::has(message(), "wall 0 has z = 1"));
        options.walls.clear();
        options.periodic[2] = true;
        CHECK(test::has(message(), "Options::periodic: z repeats"));
        options.periodic[2] = false;
        options.want.faces = true;
        const auto t = votess::tessellate(std::span<const double>(points), options);
        CHECK_THROWS_WITH_AS((void)votess::delaunay(t), doctest::Contains("three dimensions"), votess::Error);
        CHECK_THROWS_AS((void)votess::tessellate(std::span<const double>(points).first(3), options), votess::Error);
    }
}

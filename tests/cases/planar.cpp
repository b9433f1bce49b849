// Cells of the plane, against half-planes clipped in rational numbers.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "oracle/planar_cells.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/text.hpp"
#include "votess/diagram.hpp"
#include "votess/fit.hpp"
#include "votess/pieces.hpp"
#include "votess/votess.hpp"

namespace {

using test::PlanarCell, test::PlanarLabel, test::PlanarSet;

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
        const PlanarCell cell = test::exact_planar_cell(set, i);
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

// A random set, in turn in the plane without end and in a polygon.
PlanarSet set_of_units(std::size_t number) {
    PlanarSet set = test::random_planar_set(number + 20);
    set.options.planar = set.options.list_walls = true;
    set.options.weights = set.weights;
    set.options.device = "cpu";
    if (number % 4 == 1) {
        set.options.cell.reset();
        set.options.walls.clear();
        set.options.periodic = {};
        constexpr double end = std::numeric_limits<double>::infinity();
        set.options.box = votess::Box{{-end, -end, 0}, {end, end, 0}};
    }
    if (number % 4 == 0) {
        static const std::vector<double> corners{1, 1, 15, 2, 14, 15, 7, 6, 2, 14};
        static const std::vector<std::int32_t> edges{0, 1, 1, 2, 2, 3, 3, 4, 4, 0};
        set.options = {};
        set.options.planar = true;
        set.options.device = "cpu";
        set.options.mesh = votess::TriangleMesh{corners, edges};
        set.points = {3, 3, 8, 3.5, 12, 4, 13, 9, 11, 6, 5, 7, 3.5, 9, 13.25, 12.5, 6, 4.5};
        set.weights = {};
    }
    return set;
}

PlanarSet in_unit(PlanarSet set, double unit) {
    static std::vector<double> corners;  // of the mesh
    votess::Options& o = set.options;
    for (double& x : set.points) x *= unit;
    for (double& w : set.weights) w *= unit * unit;
    o.weights = set.weights;
    if (o.box)
        for (std::size_t k = 0; k < 2; ++k) o.box->lower[k] *= unit, o.box->upper[k] *= unit;
    if (o.cell)
        for (auto* edge : {&o.cell->origin, &o.cell->a, &o.cell->b})
            for (double& x : *edge) x *= unit;
    for (votess::Wall& wall : o.walls) wall.offset *= unit;
    if (o.mesh) {
        corners.assign(o.mesh->vertices.begin(), o.mesh->vertices.end());
        for (double& x : corners) x *= unit;
        o.mesh->vertices = corners;
    }
    return set;
}

// Whether numbers are exactly those times a factor; NaN for NaN.
bool are_times(std::span<const double> numbers, std::span<const double> those, double factor) {
    return std::ranges::equal(numbers, those,
                              [&](double x, double y) { return x == y * factor || (std::isnan(x) && std::isnan(y)); });
}

// Compares all numbers of a set with those in another unit, and checks them.
std::string compare_units(PlanarSet set, double unit) {
    votess::Want& want =
        set.options.want = {.neighbors = true, .volumes = true, .centroids = true, .areas = true, .surfaces = true};
    want.radii = want.vertices = want.faces = want.counts = !set.options.mesh;
    const PlanarSet other = in_unit(set, unit);
    const auto t = votess::tessellate(std::span<const double>(set.points), set.options);
    const auto u = votess::tessellate(std::span<const double>(other.points), other.options);
    if (!std::ranges::equal(t.indices(), u.indices())) return "neighbors";
    if (!are_times(u.volumes(), t.volumes(), unit * unit)) return "areas";
    if (!are_times(u.face_areas(), t.face_areas(), unit)) return "lengths";
    if (!are_times(u.surface_areas(), t.surface_areas(), unit)) return "perimeters";
    if (!are_times(u.mesh_areas(), t.mesh_areas(), unit)) return "outlines";
    if (!are_times(u.security_radii(), t.security_radii(), unit)) return "radii";
    if (!are_times(u.centroids(), t.centroids(), unit)) return "centroids";
    if (!are_times(u.vertices(), t.vertices(), unit)) return "vertices";
    if (u.stats().box_volume != t.stats().box_volume * unit * unit) return "area of the domain";
    if (u.stats().volume_sum != t.stats().volume_sum * unit * unit) return "sum";
    if (!t.stats().tiny_faces != !u.stats().tiny_faces) return "tiny faces";
    if (set.options.mesh) {
        const votess::Pieces one = votess::pieces(t), more = votess::pieces(u);
        if (!are_times(more.volumes, one.volumes, unit * unit)) return "pieces";
    }
    const votess::VerifyReport here = votess::verify(t, set.points), there = votess::verify(u, other.points);
    if (here.proven != there.proven) return "proof: " + here.unproven + there.unproven;
    PlanarSet lists = other;
    lists.options.want = {.neighbors = true};
    const votess::VerifyReport of_lists =
        votess::verify(votess::tessellate(std::span<const double>(lists.points), lists.options), lists.points);
    if (here.proven && !of_lists.proven) return "proof of lists: " + of_lists.failure + of_lists.unproven;
    return here.failure + there.failure;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("planar: random sets in all domains equal rational half-planes") {
        for (std::uint64_t number = 0; number < test::by_size(30, 12); ++number) {
            CAPTURE(number);
            CHECK(compare_cells(test::random_planar_set(number)) == "");
        }
    }

    TEST_CASE("planar: measures in any unit that is a power of two have the same digits") {
        for (std::size_t number = 0; number < test::by_size(12, 6); ++number)
            for (const int power : {-500, -340, 20, 500}) {
                CAPTURE(number);
                CAPTURE(power);
                CHECK(compare_units(set_of_units(number), std::ldexp(1.0, power)) == "");
            }
    }

    TEST_CASE("planar: cells in a mesh have lengths and centroids where areas leave the range of numbers") {
        std::size_t meshes = 0;
        for (std::size_t number = 0; number < test::by_size(12, 6); ++number)
            for (const int power : {-900, -560, 560, 900}) {
                CAPTURE(number);
                CAPTURE(power);
                PlanarSet set = set_of_units(number);
                if (!set.options.mesh) continue;
                ++meshes;
                const double unit = std::ldexp(1.0, power);
                set.options.want = {.neighbors = true, .volumes = true, .centroids = true, .areas = true};
                const PlanarSet other = in_unit(set, unit);
                const auto t = votess::tessellate(std::span<const double>(set.points), set.options);
                const auto u = votess::tessellate(std::span<const double>(other.points), other.options);
                CHECK(std::ranges::equal(t.indices(), u.indices()));
                CHECK(are_times(u.face_areas(), t.face_areas(), unit));
                CHECK(are_times(u.centroids(), t.centroids(), unit));
            }
        CHECK(meshes > 0);
    }

    TEST_CASE("planar: fits, queries and grids in any unit that is a power of two have the same digits") {
        const PlanarSet given = set_of_units(2);
        const std::size_t n = given.points.size() / 2;
        const std::vector<double> values(given.points.begin(), given.points.begin() + static_cast<std::ptrdiff_t>(n));
        const std::vector<double> density{1, 2, 3, 4};
        for (const bool in_mesh : {false, true}) {
            const PlanarSet one = in_mesh ? set_of_units(0) : given;
            const auto fitted = [&](const PlanarSet& set) {
                votess::FitOptions fit;
                fit.normalize = true;
                if (!in_mesh) fit.density = votess::Density{{2, 2, 1}, density};
                const std::vector<double> equal(set.points.size() / 2, 1);
                return votess::fit_volumes(set.points, equal, set.options, fit);
            };
            const votess::VolumeFit expected = fitted(one);
            for (const double unit : {0x1p-480, 0x1p480}) {
                const votess::VolumeFit found = fitted(in_unit(one, unit));
                CHECK(are_times(found.weights, expected.weights, unit * unit));
                CHECK(found.steps == expected.steps);
                CHECK(found.residual == expected.residual);
            }
        }
        for (const double unit : {0x1p-500, 0x1p500}) {
            CAPTURE(unit);
            const PlanarSet large = in_unit(given, unit);
            const votess::Diagram here(given.points, given.options), there(large.points, large.options);
            const std::vector<double> place{5.25, 6.5}, far_place{5.25 * unit, 6.5 * unit};
            CHECK(are_times(there.probe(far_place).volumes(), here.probe(place).volumes(), unit * unit));
            CHECK(there.natural_neighbors(far_place).weights == here.natural_neighbors(place).weights);
            for (const votess::GridMethod method : {votess::GridMethod::mean, votess::GridMethod::dtfe}) {
                votess::GridOptions options{{3, 2, 1}};
                options.method = method;
                std::vector<double> grid(6), other(6);
                CHECK(here.to_grid(values, options, grid) == there.to_grid(values, options, other));
                CHECK(are_times(other, grid, method == votess::GridMethod::mean ? 1 : 1 / unit / unit));
            }
        }
    }

    TEST_CASE("planar: small edges leave lists and counts, not perimeters and corners") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        const std::vector<double> corners{0, 0, 9, 1, 8, 8, 1, 7};
        const std::vector<std::int32_t> sides{0, 1, 1, 2, 2, 3, 3, 0};
        for (int kind = 0; kind < 5; ++kind)
            for (const bool walls : {false, true}) {
                CAPTURE(kind);
                CAPTURE(walls);
                test::Random random(140 + static_cast<std::uint64_t>(kind));
                std::vector<double> points(120);
                for (double& x : points) x = random.uniform(0, 10);
                votess::Options options;
                options.planar = true;
                options.periodic = {kind == 1, kind == 1, false};
                options.box = votess::Box{{0, 0, 0}, {10, 10, 0}};
                if (kind == 2) options.box = votess::Box{{-inf, -inf, 0}, {inf, inf, 0}};
                if (kind == 3) options.box.reset(), options.mesh = votess::TriangleMesh{corners, sides};
                options.list_walls = walls;
                options.want = {
                    .neighbors = true, .volumes = true, .counts = kind != 3, .areas = true, .surfaces = true};
                if (kind != 3) options.want.faces = true;
                const auto whole = votess::tessellate(std::span<const double>(points), options);
                options.min_area = kind == 4 ? 0 : 0.5;
                options.min_face = kind == 4 ? 0.3 : 0;
                const auto t = votess::tessellate(std::span<const double>(points), options);
                CHECK(std::ranges::equal(t.surface_areas(), whole.surface_areas()));
                CHECK(std::ranges::equal(t.vertices(), whole.vertices()));
                CHECK(std::ranges::equal(t.cell_vertex_indices(), whole.cell_vertex_indices()));
                std::size_t e = 0, dropped = 0;
                for (std::size_t i = 0; i < whole.size(); ++i) {
                    const std::size_t before = dropped;
                    for (auto all = whole.indptr()[i]; all < whole.indptr()[i + 1]; ++all) {
                        const auto k = static_cast<std::size_t>(all);
                        if (whole.indices()[k] >= 0 && whole.face_areas()[k] < t.least_face()) {
                            ++dropped;
                            continue;
                        }
                        REQUIRE(e < t.indices().size());
                        CHECK(t.indices()[e] == whole.indices()[k]);
                        CHECK(t.face_areas()[e++] == whole.face_areas()[k]);
                    }
                    if (kind != 3) CHECK(t.face_counts()[i] + dropped - before == whole.face_counts()[i]);
                }
                CHECK(e == t.indices().size());
                CHECK(dropped > 4);
                CHECK(t.stats().faces + dropped == whole.stats().faces);
                const auto report = votess::verify(t, points);
                CHECK(report.failure == "");
                CHECK(report.proven == (kind != 3));
            }
    }

    TEST_CASE("planar: arrays that are not wanted stay empty, float32 and no points work") {
        const PlanarSet set = test::random_planar_set(2);
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
        CHECK_THROWS_WITH((void)votess::tessellate(std::span<const double>(set.points), options),
                          doctest::Contains("Options::periodic needs a box"));
        options.periodic = {};
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
        options.box.reset();
        const auto t = votess::tessellate(std::span<const double>(points), options);
        CHECK_THROWS_WITH_AS((void)votess::count_tiny_faces(t, points), doctest::Contains("three dimensions"),
                             votess::Error);
        CHECK_THROWS_AS((void)votess::tessellate(std::span<const double>(points).first(3), options), votess::Error);
        const std::vector<double> twice{0, 0.5, 1, 1, 0, 0.5};
        options.duplicates = votess::Duplicates::error;
        CHECK_THROWS_WITH((void)votess::tessellate(std::span<const double>(twice), options),
                          doctest::Contains("(0, 0.5) is a duplicate of point 0"));
        const std::vector<double> line{0, 0, 1, 0, 2, 0};
        const std::vector<std::int32_t> ring{0, 1, 1, 2, 2, 0};
        options.box.reset();
        options.mesh = votess::TriangleMesh{line, ring};
        CHECK_THROWS_WITH((void)votess::tessellate(std::span<const double>(points).first(2), options),
                          doctest::Contains("its rings enclose no area"));
    }
}

// Cells of the plane, against half-planes clipped in rational numbers.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "oracle/planar_cells.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/text.hpp"
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

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("planar: random sets in all domains equal rational half-planes") {
        for (std::uint64_t number = 0; number < test::by_size(30, 12); ++number) {
            CAPTURE(number);
            CHECK(compare_cells(test::random_planar_set(number)) == "");
        }
    }

    TEST_CASE("planar: far from the origin, tiny and huge") {
        for (const double scale : {0x1p-200, 0x1p-30, 0x1p40, 0x1p300}) {
            CAPTURE(scale);
            PlanarSet set = test::random_planar_set(7), small = set;
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
    }
}

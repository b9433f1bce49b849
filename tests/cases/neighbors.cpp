// Rows of neighbors, counts and volumes that are known by hand: few seeds, lattices, seeds without volume, spheres.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "support/check.hpp"

namespace {

using Row = std::vector<std::int32_t>;

// The answer for these seeds in the unit box, proven exactly.
votess::Tessellation proven(const test::Coordinates& points) {
    const auto t = votess::tessellate(points, test::all_options(test::unit_box()));
    CHECK(test::check_exact(t, points) == "");
    return t;
}

Row seeds_of(const votess::Tessellation& t, std::size_t i) {
    Row row = test::row_of(t, i);
    std::erase_if(row, [](std::int32_t j) { return j < 0; });
    return row;
}

// A cell of a perfect lattice of this length, at least `margin` inside, away from the effects of its surface.
struct Lattice {
    test::PointSet set;
    double length, margin;
    std::uint32_t neighbors, edges, vertices;
    double volume;
};

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("neighbors: no seeds, an empty result") {
        const std::span<const double> none;
        for (const bool with_box : {false, true}) {
            const auto t =
                votess::tessellate(none, test::all_options(with_box ? std::optional(test::unit_box()) : std::nullopt));
            CHECK(t.size() == 0);
            REQUIRE(t.indptr().size() == 1);
            CHECK(t.indptr()[0] == 0);
            CHECK(t.indices().empty());
            CHECK(t.volumes().empty());
            CHECK(t.status().empty());
            CHECK(t.stats().points == 0);
            CHECK(t.stats().faces == 0);
            CHECK(votess::verify(t, none).passed);
        }
    }

    TEST_CASE("neighbors: one seed has the box") {
        for (const test::Coordinates& p : {test::Coordinates{0.5, 0.5, 0.5}, {0.1, 0.9, 0.3}, {0.0, 1.0, 0.0}}) {
            const auto t = proven(p);
            CHECK(test::row_of(t, 0) == Row{-6, -5, -4, -3, -2, -1});
            CHECK(t.volumes()[0] == doctest::Approx(1).epsilon(1e-14));
            for (std::size_t a = 0; a < 3; ++a) CHECK(std::abs(t.centroids()[a] - 0.5) <= 1e-15);
            CHECK(t.vertex_counts()[0] == 8);
        }
    }

    TEST_CASE("neighbors: two seeds share one face") {
        const auto t = proven({0.25, 0.5, 0.5, 0.5, 0.5, 0.5});
        CHECK(test::row_of(t, 0) == Row{-6, -5, -4, -3, -1, 1});
        CHECK(test::row_of(t, 1) == Row{-6, -5, -4, -3, -2, 0});
        CHECK(t.volumes()[0] == doctest::Approx(0.375).epsilon(1e-14));
        CHECK(t.volumes()[1] == doctest::Approx(0.625).epsilon(1e-14));
        // One step of nextafter apart.
        for (const double x : {0.5, 0.3, 1e-5})
            CHECK(test::row_of(proven({x, 0.4, 0.6, std::nextafter(x, 1.0), 0.4, 0.6}), 0) ==
                  Row{-6, -5, -4, -3, -1, 1});
        // In opposite corners the bisector is a hexagon through corners of the box, or goes through two of its edges.
        const auto corners = proven({0, 0, 0, 1, 1, 1});
        CHECK(corners.face_counts()[0] == 7);
        CHECK(corners.volumes()[0] == doctest::Approx(0.5).epsilon(1e-14));
        const auto prisms = proven({0, 0, 0.5, 1, 1, 0.5});
        CHECK(test::row_of(prisms, 0) == Row{-6, -5, -3, -1, 1});
        CHECK(prisms.vertex_counts()[0] == 6);
    }

    TEST_CASE("neighbors: a square, a tetrahedron, the corners of the box") {
        const auto square = proven({0.25, 0.25, 0.5, 0.75, 0.25, 0.5, 0.25, 0.75, 0.5, 0.75, 0.75, 0.5});
        CHECK(test::row_of(square, 0) == Row{-6, -5, -3, -1, 1, 2});
        CHECK(test::row_of(square, 3) == Row{-6, -5, -4, -2, 1, 2});
        CHECK(square.volumes()[2] == doctest::Approx(0.25).epsilon(1e-14));
        const auto tetrahedron = proven({0.25, 0.25, 0.25, 0.75, 0.75, 0.25, 0.75, 0.25, 0.75, 0.25, 0.75, 0.75});
        for (std::size_t i = 0; i < 4; ++i) {
            CHECK(tetrahedron.volumes()[i] == doctest::Approx(0.25).epsilon(1e-14));
            CHECK(seeds_of(tetrahedron, i).size() == 3);
        }
        const auto corners = proven(test::cubic(2).points);
        for (std::size_t i = 0; i < 8; ++i) {
            CHECK(corners.neighbors(i).size() == 6);
            CHECK(corners.volumes()[i] == doctest::Approx(0.125).epsilon(1e-14));
        }
    }

    TEST_CASE("neighbors: every row of a cubic lattice, walls included") {
        for (const auto& [n, spacing] :
             {std::pair<std::size_t, double>{2, 1}, {5, 1}, {test::by_size(24, 8), 1}, {6, 0x1p-40}, {6, 3 * 0x1p40}}) {
            const test::PointSet set = test::cubic(n, spacing);
            const auto t = test::run(set);
            CHECK(test::check_invariants(t, set.points) == "");
            const auto m = static_cast<std::int32_t>(n);
            for (std::int32_t i = 0; i < m * m * m; ++i) {
                const std::int32_t step[3] = {m * m, m, 1}, at[3] = {i / (m * m), i / m % m, i % m};
                Row expected;
                for (int k = 2; k >= 0; --k) {
                    if (at[k] == m - 1) expected.push_back(-2 - 2 * k);
                    if (at[k] == 0) expected.push_back(-1 - 2 * k);
                }
                for (int k = 0; k < 3; ++k)
                    if (at[k] > 0) expected.push_back(i - step[k]);
                for (int k = 2; k >= 0; --k)
                    if (at[k] < m - 1) expected.push_back(i + step[k]);
                const auto cell = static_cast<std::size_t>(i);
                REQUIRE(test::row_of(t, cell) == expected);
                REQUIRE(t.vertex_counts()[cell] == 8);
                REQUIRE(std::abs(t.volumes()[cell] / std::pow(spacing, 3) - 1) <= 1e-12);
                for (std::size_t a = 0; a < 3; ++a)
                    REQUIRE(std::abs(t.centroids()[3 * cell + a] - set.points[3 * cell + a]) <= 1e-12 * spacing * n);
            }
        }
    }

    TEST_CASE("neighbors: cells of lattices as crystallography knows them") {
        const auto size = [](int full, int reduced) { return test::reduced() ? reduced : full; };
        const int cubic = size(16, 8), fcc = size(14, 7), prisms = size(14, 8), packed = size(30, 22),
                  diamond = size(18, 12);
        for (const Lattice& lattice : {Lattice{test::bcc(cubic), 1. * cubic, 2, 14, 36, 24, 4},  // truncated octahedra
                                       {test::fcc(fcc), 1. * fcc, 2, 12, 24, 14, 2},             // rhombic dodecahedra
                                       {test::hexagonal(prisms), 1. * prisms, 3, 8, 18, 12, 3},
                                       {test::close_packed(packed), 1. * packed, 7, 12, 24, 14, 54},
                                       {test::diamond(diamond), 1. * diamond, 4, 16, 30, 16, 8}}) {
            CAPTURE(lattice.set.name);
            const auto t = test::run(lattice.set);
            CHECK(test::check_invariants(t, lattice.set.points) == "");
            std::size_t interior = 0;
            for (std::size_t i = 0; i < t.size(); ++i) {
                if (!std::ranges::all_of(std::span(lattice.set.points).subspan(3 * i, 3), [&](double x) {
                        return x >= lattice.margin && x <= lattice.length - lattice.margin;
                    }))
                    continue;
                ++interior;
                CAPTURE(i);
                REQUIRE(t.neighbors(i).size() == lattice.neighbors);
                REQUIRE(t.face_counts()[i] == lattice.neighbors);
                REQUIRE(t.edge_counts()[i] == lattice.edges);
                REQUIRE(t.vertex_counts()[i] == lattice.vertices);
                REQUIRE(std::abs(t.volumes()[i] - lattice.volume) <= 1e-12 * lattice.volume);
            }
            CHECK(interior >= 8);
        }
    }

    TEST_CASE("neighbors: lattices in any order, and with rounded coordinates") {
        for (const auto order : {test::Order::reversed, test::Order::interleaved, test::Order::by_last_coordinate,
                                 test::Order::shuffled}) {
            const test::PointSet set = test::reordered(test::cubic(6), order);
            const auto t = test::run(set);
            CHECK(test::check_invariants(t, set.points) == "");
            for (std::size_t i = 0; i < set.size(); ++i) REQUIRE(t.neighbors(i).size() == 6);  // walls included
        }
        for (const double spacing : {0.1, 1.0 / 3, 1e-7, 1e7 / 3}) {
            CAPTURE(spacing);
            const test::PointSet set = test::cubic(test::by_size(12, 6), spacing);
            const auto t = test::run(set);
            CHECK(test::check_invariants(t, set.points) == "");
            for (std::size_t i = 0; i < set.size(); ++i)
                REQUIRE(std::abs(t.volumes()[i] / (spacing * spacing * spacing) - 1) <= 1e-12);
        }
        for (const double amplitude : {1e-3, 1e-9, 1e-15}) {
            CAPTURE(amplitude);
            const test::PointSet set = test::jittered(test::by_size(14, 6), amplitude, 5);
            CHECK(test::check_invariants(test::run(set), set.points) == "");
        }
    }

    TEST_CASE("neighbors: invariants of every family") {
        for (const std::size_t n : {test::by_size(400, 150), test::by_size(4000, 400)})
            for (const test::PointSet& set : test::families(n, n)) {
                CAPTURE(set.name);
                CAPTURE(n);
                const auto t = test::run(set);
                CHECK(test::check_invariants(t, set.points) == "");
                const auto report = votess::verify(t, set.points, {64, 1});
                CHECK(report.failure == "");
                CHECK(report.passed);
                CHECK(report.skipped.empty());
            }
    }

    // The walk cannot see the walls in its units.
    TEST_CASE("neighbors: clusters in a corner of a far larger box") {
        for (const double size : {1e-2, 1e-3, 1e-6}) {
            CAPTURE(size);
            const auto set = test::scaled(test::clustered(test::by_size(2000, 500), 3), size);
            votess::Options options;
            options.box = test::unit_box();
            const auto t = votess::tessellate(set.points, options);
            CHECK(votess::verify(t, set.points).failure == "");
        }
    }

    TEST_CASE("neighbors: seeds on a line have the one before and the one after") {
        for (const test::PointSet& set :
             {test::on_axis_line(test::by_size(2000, 200), 5), test::on_oblique_line(test::by_size(2000, 200), 6)}) {
            CAPTURE(set.name);
            const auto t = test::run(set);
            std::vector<std::pair<double, std::int32_t>> order;
            for (std::size_t i = 0; i < set.size(); ++i)
                if (t.status()[i] != votess::CellStatus::duplicate)
                    order.emplace_back(set.points[3 * i + 1], static_cast<std::int32_t>(i));
            std::ranges::sort(order);
            for (std::size_t k = 0; k < order.size(); ++k) {
                Row expected;
                if (k > 0) expected.push_back(order[k - 1].second);
                if (k + 1 < order.size()) expected.push_back(order[k + 1].second);
                std::ranges::sort(expected);
                REQUIRE(seeds_of(t, static_cast<std::size_t>(order[k].second)) == expected);
            }
        }
    }

    TEST_CASE("neighbors: seeds on a plane have prisms") {
        const test::PointSet set = test::on_axis_plane(test::by_size(3000, 300), 7);
        const auto t = test::run(set);
        CHECK(test::check_invariants(t, set.points) == "");
        for (std::size_t i = 0; i < set.size(); ++i) {
            const auto sides = t.face_counts()[i] - 2;
            REQUIRE(t.neighbors(i)[0] == -6);
            REQUIRE(t.neighbors(i)[1] == -5);
            REQUIRE(t.vertex_counts()[i] == 2 * sides);
            REQUIRE(t.edge_counts()[i] == 3 * sides);
            REQUIRE(std::abs(t.centroids()[3 * i + 2] - 0.5) <= 1e-12);
        }
        // Integers on an oblique plane.
        test::PointSet grid{"grid on an oblique plane", {}, test::cube(-200, 200)};
        for (int u = -10; u <= 10; ++u)  // orthogonal steps in the plane x + y + z = 0
            for (int v = -10; v <= 10; ++v) grid.points.insert(grid.points.end(), {1. * u + v, 1. * v - u, -2. * v});
        const auto oblique = test::run(grid);
        CHECK(test::check_invariants(oblique, grid.points) == "");
        for (int i = 22; i < 21 * 20 - 1; ++i)
            if (i % 21 != 0 && i % 21 != 20)
                REQUIRE(seeds_of(oblique, static_cast<std::size_t>(i)) == Row{i - 21, i - 1, i + 1, i + 21});
    }

    TEST_CASE("neighbors: a seed with a face for each of the others around it") {
        for (const test::PointSet& set : {test::cospherical_and_center(101), test::cospherical_and_center(1001),
                                          test::on_sphere_and_center(test::by_size(1500, 300), 9)}) {
            CAPTURE(set.name);
            const std::size_t n = set.size();
            CAPTURE(n);
            const auto t = test::run(set);
            CHECK(test::check_invariants(t, set.points) == "");
            CHECK(seeds_of(t, n - 1).size() == n - 1);
            CHECK(t.neighbors(n - 1)[0] == 0);  // no walls
        }
    }

    TEST_CASE("neighbors: the symmetries of a cospherical set are those of its cells") {
        const test::PointSet set = test::cospherical(101);
        const auto t = test::run(set);
        CHECK(test::check_invariants(t, set.points) == "");
        const auto key = [&](std::size_t i) {
            std::array<double, 3> k{std::abs(set.points[3 * i]), std::abs(set.points[3 * i + 1]),
                                    std::abs(set.points[3 * i + 2])};
            std::ranges::sort(k);
            return k;
        };
        for (std::size_t i = 0; i < set.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (key(i) == key(j)) {
                    REQUIRE(t.face_counts()[i] == t.face_counts()[j]);
                    REQUIRE(t.vertex_counts()[i] == t.vertex_counts()[j]);
                    REQUIRE(t.volumes()[i] == doctest::Approx(t.volumes()[j]).epsilon(1e-12));
                }
    }

    TEST_CASE("neighbors: seeds on walls, edges and corners of the box touch them") {
        const test::PointSet set = test::on_walls(test::by_size(3000, 300), 10);
        const auto t = test::run(set);
        CHECK(test::check_invariants(t, set.points) == "");
        for (std::size_t c = 0; c < set.points.size(); ++c) {
            if (t.status()[c / 3] == votess::CellStatus::duplicate) continue;
            for (const int high : {0, 1})
                if (set.points[c] == high)
                    REQUIRE(std::ranges::binary_search(t.neighbors(c / 3), -1 - 2 * static_cast<int>(c % 3) - high));
        }
    }

    TEST_CASE("neighbors: walls are listed when they are requested") {
        const test::PointSet set = test::uniform(500, 12);
        votess::Options options = test::all_options();
        const auto with = test::run(set, options);
        options.list_walls = false;
        const auto without = test::run(set, options);
        CHECK(with.lists_walls());
        CHECK_FALSE(without.lists_walls());
        CHECK(test::check_invariants(without, set.points) == "");
        std::size_t walls = 0;
        for (std::size_t i = 0; i < set.size(); ++i) {
            REQUIRE(seeds_of(with, i) == test::row_of(without, i));
            walls += with.neighbors(i).size() - without.neighbors(i).size();
        }
        CHECK(walls > 100);
        CHECK(std::ranges::equal(with.face_counts(), without.face_counts()));
    }
}

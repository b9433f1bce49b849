// Rows of neighbors, counts and volumes that are known by hand: none, lattices; and invariants of every family.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "support/check.hpp"

namespace {

using Row = std::vector<std::int32_t>;

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

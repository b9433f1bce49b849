// Golden topology: perfect lattices, whose cells are known from crystallography.
#include <doctest/doctest.h>

#include <cmath>

#include "support/check.hpp"

namespace {

struct Golden {
    std::uint32_t neighbors, edges, vertices;
    double volume;
};

// Cells whose seed is at least `margin` inside the lattice's cube, away from what its surface does.
void check_interior(const test::PointSet& set, double length, double margin, const Golden& golden) {
    CAPTURE(set.name);
    const auto t = test::run(set);
    CHECK(test::check_invariants(t, set.points) == "");
    std::size_t interior = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a)
            inside = inside && set.points[3 * i + a] >= margin && set.points[3 * i + a] <= length - margin;
        if (!inside) continue;
        ++interior;
        CAPTURE(i);
        REQUIRE(t.neighbors(i).size() == golden.neighbors);
        REQUIRE(t.face_counts()[i] == golden.neighbors);
        REQUIRE(t.edge_counts()[i] == golden.edges);
        REQUIRE(t.vertex_counts()[i] == golden.vertices);
        REQUIRE(std::abs(t.volumes()[i] - golden.volume) <= 1e-12 * golden.volume);
    }
    CHECK(interior >= 8);
}

// All rows of the integer lattice in a box half a unit outside, walls included.
void check_cubic(std::size_t n, double spacing) {
    const test::PointSet set = test::cubic(n, spacing);
    const auto t = test::run(set);
    CHECK(test::check_invariants(t, set.points) == "");
    const auto m = static_cast<std::int32_t>(n);
    for (std::int32_t x = 0; x < m; ++x)
        for (std::int32_t y = 0; y < m; ++y)
            for (std::int32_t z = 0; z < m; ++z) {
                const std::int32_t i = (x * m + y) * m + z;
                std::vector<std::int32_t> expected;
                if (z == m - 1) expected.push_back(-6);
                if (z == 0) expected.push_back(-5);
                if (y == m - 1) expected.push_back(-4);
                if (y == 0) expected.push_back(-3);
                if (x == m - 1) expected.push_back(-2);
                if (x == 0) expected.push_back(-1);
                if (x > 0) expected.push_back(i - m * m);
                if (y > 0) expected.push_back(i - m);
                if (z > 0) expected.push_back(i - 1);
                if (z < m - 1) expected.push_back(i + 1);
                if (y < m - 1) expected.push_back(i + m);
                if (x < m - 1) expected.push_back(i + m * m);
                const auto cell = static_cast<std::size_t>(i);
                REQUIRE(test::row_of(t, cell) == expected);
                REQUIRE(t.vertex_counts()[cell] == 8);
                REQUIRE(std::abs(t.volumes()[cell] / std::pow(spacing, 3) - 1) <= 1e-12);
                for (std::size_t a = 0; a < 3; ++a)
                    REQUIRE(std::abs(t.centroids()[3 * cell + a] - set.points[3 * cell + a]) <= 1e-12 * spacing * n);
            }
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("cubic lattice: cubes with six neighbors, every row") {
        check_cubic(2, 1);
        check_cubic(5, 1);
        check_cubic(test::by_size(24, 8), 1);
        check_cubic(6, 0x1p-40);
        check_cubic(6, 3 * 0x1p40);
    }

    TEST_CASE("bcc lattice: truncated octahedra") {
        const int length = static_cast<int>(test::by_size(16, 8));
        check_interior(test::bcc(length), length, 2, {14, 36, 24, 4});
    }

    TEST_CASE("fcc lattice: rhombic dodecahedra") {
        const int length = static_cast<int>(test::by_size(14, 7));
        check_interior(test::fcc(length), length, 2, {12, 24, 14, 2});
    }

    TEST_CASE("hexagonal lattice: hexagonal prisms") {
        const int length = static_cast<int>(test::by_size(14, 8));
        check_interior(test::hexagonal(length), length, 3, {8, 18, 12, 3});
    }

    TEST_CASE("hexagonal close-packed lattice: trapezo-rhombic dodecahedra") {
        const int length = static_cast<int>(test::by_size(30, 22));
        check_interior(test::close_packed(length), length, 7, {12, 24, 14, 54});
    }

    TEST_CASE("diamond lattice: triakis truncated tetrahedra") {
        const int length = static_cast<int>(test::by_size(18, 12));
        check_interior(test::diamond(length), length, 4, {16, 30, 16, 8});
    }

    TEST_CASE("cubic lattice: any order of the seeds") {
        const test::PointSet base = test::cubic(6);
        for (const auto order : {test::Order::reversed, test::Order::interleaved, test::Order::by_last_coordinate,
                                 test::Order::shuffled}) {
            const test::PointSet set = test::reordered(base, order);
            const auto t = test::run(set);
            CHECK(test::check_invariants(t, set.points) == "");
            for (std::size_t i = 0; i < set.size(); ++i) REQUIRE(t.neighbors(i).size() == 6);  // walls included
        }
    }

    TEST_CASE("lattices with rounded coordinates stay consistent") {
        for (const double spacing : {0.1, 1.0 / 3, 1e-7, 1e7 / 3}) {
            const test::PointSet set = test::cubic(test::by_size(12, 6), spacing);
            CAPTURE(spacing);
            const auto t = test::run(set);
            CHECK(test::check_invariants(t, set.points) == "");
            for (std::size_t i = 0; i < set.size(); ++i)
                REQUIRE(std::abs(t.volumes()[i] / (spacing * spacing * spacing) - 1) <= 1e-12);
        }
        for (const double amplitude : {1e-3, 1e-9, 1e-15}) {
            const test::PointSet set = test::jittered(test::by_size(14, 6), amplitude, 5);
            CAPTURE(amplitude);
            CHECK(test::check_invariants(test::run(set), set.points) == "");
        }
    }
}

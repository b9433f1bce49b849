// The invariants on every family of inputs, larger than brute force allows, and what is known of special shapes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "support/check.hpp"

namespace {

std::size_t count_seeds(const votess::Tessellation& t, std::size_t i) {
    const auto row = t.neighbors(i);
    return static_cast<std::size_t>(std::count_if(row.begin(), row.end(), [](std::int32_t j) { return j >= 0; }));
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("invariants of every family") {
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

    TEST_CASE("seeds on a line: slabs, each with the one before and the one after") {
        for (test::PointSet set :
             {test::on_axis_line(test::by_size(2000, 200), 5), test::on_oblique_line(test::by_size(2000, 200), 6)}) {
            CAPTURE(set.name);
            const auto t = test::run(set);
            std::vector<std::pair<double, std::size_t>> order;
            for (std::size_t i = 0; i < set.size(); ++i)
                if (t.status()[i] != votess::CellStatus::duplicate) order.emplace_back(set.points[3 * i + 1], i);
            std::sort(order.begin(), order.end());
            for (std::size_t k = 0; k < order.size(); ++k) {
                std::vector<std::int32_t> expected;
                if (k > 0) expected.push_back(static_cast<std::int32_t>(order[k - 1].second));
                if (k + 1 < order.size()) expected.push_back(static_cast<std::int32_t>(order[k + 1].second));
                std::sort(expected.begin(), expected.end());
                auto row = test::row_of(t, order[k].second);
                std::erase_if(row, [](std::int32_t j) { return j < 0; });
                REQUIRE(row == expected);
            }
        }
    }

    TEST_CASE("seeds on an axis-parallel plane: prisms from floor to ceiling") {
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
    }

    TEST_CASE("integer grid on an oblique plane: each inner cell an infinite prism cut by the box") {
        test::PointSet set{"grid on an oblique plane", {}, test::cube(-200, 200)};
        for (int u = -10; u <= 10; ++u)  // orthogonal steps in the plane x + y + z = 0
            for (int v = -10; v <= 10; ++v)
                set.points.insert(set.points.end(),
                                  {static_cast<double>(u + v), static_cast<double>(-u + v), -2.0 * v});
        const auto t = test::run(set);
        CHECK(test::check_invariants(t, set.points) == "");
        for (int u = -9; u <= 9; ++u)
            for (int v = -9; v <= 9; ++v) {
                const int i = (u + 10) * 21 + v + 10;
                auto row = test::row_of(t, static_cast<std::size_t>(i));
                std::erase_if(row, [](std::int32_t j) { return j < 0; });
                REQUIRE(row == std::vector<std::int32_t>{i - 21, i - 1, i + 1, i + 21});
            }
    }

    TEST_CASE("a seed with a face for each of the others around it") {
        for (const test::PointSet& set : {test::cospherical_and_center(101), test::cospherical_and_center(1001),
                                          test::on_sphere_and_center(test::by_size(1500, 300), 9)}) {
            CAPTURE(set.name);
            const std::size_t n = set.size();
            CAPTURE(n);
            const auto t = test::run(set);
            CHECK(test::check_invariants(t, set.points) == "");
            CHECK(count_seeds(t, n - 1) == n - 1);
            CHECK(t.neighbors(n - 1)[0] == 0);  // no walls
        }
    }

    TEST_CASE("cospherical seeds: every cell reaches the common center, none but true faces listed") {
        // The symmetry of the 48 rotations and reflections maps the set on itself, so cells come in equal classes.
        const test::PointSet set = test::cospherical(101);
        const auto t = test::run(set);
        CHECK(test::check_invariants(t, set.points) == "");
        const auto key = [&](std::size_t i) {
            std::array<double, 3> k{std::abs(set.points[3 * i]), std::abs(set.points[3 * i + 1]),
                                    std::abs(set.points[3 * i + 2])};
            std::sort(k.begin(), k.end());
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

    TEST_CASE("seeds on walls, edges and corners of the box") {
        const test::PointSet set = test::on_walls(test::by_size(3000, 300), 10);
        const auto t = test::run(set);
        CHECK(test::check_invariants(t, set.points) == "");
        for (std::size_t i = 0; i < set.size(); ++i) {
            if (t.status()[i] == votess::CellStatus::duplicate) continue;
            for (std::size_t a = 0; a < 3; ++a)
                for (const int high : {0, 1})
                    if (set.points[3 * i + a] == high) {
                        const auto row = t.neighbors(i);
                        REQUIRE(std::binary_search(row.begin(), row.end(),
                                                   static_cast<std::int32_t>(-1 - 2 * static_cast<int>(a) - high)));
                    }
        }
    }

    TEST_CASE("walls are listed only when asked for") {
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
            auto row = test::row_of(with, i);
            walls += std::erase_if(row, [](std::int32_t j) { return j < 0; });
            REQUIRE(row == test::row_of(without, i));
        }
        CHECK(walls > 100);
        CHECK(std::equal(with.face_counts().begin(), with.face_counts().end(), without.face_counts().begin()));
    }
}

// Results, stats and devices of a Tessellator; histories.cpp has sequences of calls.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>
#include <votess/alpha.hpp>
#include <votess/network.hpp>
#include <votess/pieces.hpp>
#include <votess/row_arrays.hpp>

#include "support/check.hpp"
#include "support/random.hpp"

TEST_SUITE("interface") {
    TEST_CASE("tessellator: seeds that move") {
        const std::size_t n = test::by_size(6000, 600);
        const double spacing = 1 / std::cbrt(static_cast<double>(n));
        for (const unsigned threads : {1u, 3u})
            for (const double distance : {0.0, 1e-12, 0.01, 1.0}) {
                CAPTURE(distance);
                test::Random random(71);
                test::Coordinates points = test::uniform(n, 72).points;
                votess::Options options = test::all_options(test::unit_box());
                options.threads = threads;
                votess::Tessellator kept;
                for (int step = 0; step < 3; ++step) {
                    const auto t = kept.tessellate(points, options);
                    CHECK(test::check_identical(t, votess::tessellate(points, options)) == "");
                    CHECK(test::check_invariants(t, points) == "");
                    for (double& x : points) x = std::clamp(x + distance * spacing * random.uniform(-1, 1), 0.0, 1.0);
                }
            }
    }

    TEST_CASE("tessellator: a Tessellator that was moved from refuses") {
        const test::PointSet set = test::uniform(100, 74);
        votess::Tessellator tessellator;
        const votess::Tessellator other = std::move(tessellator);
        CHECK(test::error_of([&] { (void)tessellator.tessellate(set.points); }) == votess::ErrorCode::invalid_use);
        tessellator = votess::Tessellator();
        CHECK(tessellator.tessellate(set.points).size() == 100);
    }

    TEST_CASE("tessellator: a result outlives its Tessellator and its copies") {
        const test::PointSet set = test::uniform(500, 84);
        const auto expected = test::run(set);
        votess::Tessellation kept;
        {
            votess::Tessellator tessellator;
            const auto t = tessellator.tessellate(set.points, test::all_options(set.box));
            kept = t;
            const auto other = tessellator.tessellate(test::uniform(700, 85).points);
            CHECK(other.size() == 700);
        }
        CHECK(test::check_identical(expected, kept) == "");
    }

    TEST_CASE("tessellator: a Tessellation that was moved from, or default-constructed, is empty") {
        votess::Tessellation t = votess::tessellate(test::uniform(20, 84).points, test::all_options());
        const votess::Tessellation taken = std::move(t);
        CHECK(taken.size() == 20);
        const votess::Tessellation none, null(nullptr);
        for (const votess::Tessellation* empty :
             {&std::as_const(t), &none, &null}) {  // NOLINT(bugprone-use-after-move)
            const votess::Tessellation& e = *empty;
            CHECK(e.size() == 0);
            CHECK(e.indptr().size() == 1);
            CHECK(e.indptr()[0] == 0);
            CHECK(e.neighbors(0).empty());
            votess::for_all_arrays([&](const auto& array) {
                CAPTURE(std::string(array.name));
                if (array.name != "indptr") CHECK(array.of(e).empty());
            });
            CHECK(e.walls().empty());
            CHECK(e.least_face() == 0);
            CHECK(e.box().upper == std::array<double, 3>{});
            CHECK(e.periodic() == std::array<bool, 3>{});
            CHECK(!e.cell());
            CHECK_FALSE((e.planar() || e.lists_walls() || e.probed() || e.in_mesh() || e.is_subset()));
            CHECK(e.stats().points == 0);
            CHECK(votess::verify(e, {}).passed);
            CHECK(votess::wrapped_points(e, {}).empty());
            CHECK(votess::delaunay(e).tetrahedra.empty());
            CHECK(votess::network(e, {}).points.empty());
            CHECK(votess::alpha_complex(e, {}).simplices[0].seeds.empty());
            CHECK_THROWS_AS((void)votess::pieces(e), votess::Error);
        }
        t = taken;
        CHECK(t.size() == 20);
    }

    TEST_CASE("tessellator: stats") {
        const test::PointSet set = test::cubic(8);
        const auto t = test::run(set);
        CHECK(t.stats().points == 512);
        CHECK(t.stats().faces == 512 * 6);
        CHECK(t.stats().mean_faces == 6);
        CHECK(t.stats().box_volume == 512);
        CHECK(t.stats().exact_cells > 0);  // a lattice is all ties
        CHECK(test::run(test::uniform(500, 87)).stats().fallback_cells == 0);
    }

    TEST_CASE("tessellator: devices") {
        const auto all = votess::devices();
        REQUIRE_FALSE(all.empty());
        CHECK(std::any_of(all.begin(), all.end(), [](const auto& device) { return device.id == "cpu"; }));
        for (const auto& device : all) {
            CHECK(device.name != "");
            votess::Options options;
            options.device = device.id;
            CHECK(votess::tessellate(test::uniform(50, 92).points, options).size() == 50);
        }
    }
}

// Results, stats and devices of a Tessellator; histories.cpp has sequences of calls.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

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

    TEST_CASE("tessellator: a default-constructed Tessellation is empty") {
        const votess::Tessellation t;
        CHECK(t.size() == 0);
        CHECK(t.indices().empty());
        CHECK(t.volumes().empty());
        CHECK(t.status().empty());
        CHECK(t.stats().points == 0);
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

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "support/check.hpp"

TEST_SUITE("cases") {
    TEST_CASE("10,000 seeds with 100 duplicates: the others as if these were absent") {
        const std::size_t n = test::by_size(10000, 1000), copies = 100;
        const test::PointSet set = test::with_duplicates(n, copies, 31);
        const auto t = test::run(set);
        CHECK(test::check_invariants(t, set.points) == "");
        CHECK(t.stats().duplicates == copies);
        CHECK(t.stats().empty_cells == copies);

        test::PointSet distinct{"distinct", {}, set.box};
        std::map<std::array<double, 3>, std::int32_t> first;
        std::vector<std::int32_t> kept;  // index in set of each point of distinct
        for (std::size_t i = 0; i < n; ++i) {
            const std::array p{set.points[3 * i], set.points[3 * i + 1], set.points[3 * i + 2]};
            const auto [at, is_new] = first.emplace(p, static_cast<std::int32_t>(i));
            CHECK(t.duplicate_of()[i] == (is_new ? -1 : at->second));
            if (!is_new) continue;
            kept.push_back(static_cast<std::int32_t>(i));
            distinct.points.insert(distinct.points.end(), p.begin(), p.end());
        }
        REQUIRE(kept.size() == n - copies);
        const auto u = test::run(distinct);
        for (std::size_t k = 0; k < kept.size(); ++k) {
            const auto i = static_cast<std::size_t>(kept[k]);
            auto row = test::row_of(u, k);
            for (auto& j : row)
                if (j >= 0) j = kept[static_cast<std::size_t>(j)];
            REQUIRE(row == test::row_of(t, i));
            REQUIRE(t.face_counts()[i] == u.face_counts()[k]);
            REQUIRE(std::abs(t.volumes()[i] - u.volumes()[k]) <= 1e-12 * u.volumes()[k]);
        }
    }

    TEST_CASE("duplicates = error names the first duplicate") {
        test::PointSet set = test::uniform(400, 32);
        for (std::size_t a = 0; a < 3; ++a) set.points[3 * 317 + a] = set.points[3 * 123 + a];
        votess::Options options = test::all_options();
        options.duplicates = votess::Duplicates::error;
        try {
            const auto t = test::run(set, options);
            FAIL("accepted");
        } catch (const votess::Error& error) {
            CHECK(error.code() == votess::ErrorCode::invalid_argument);
            CHECK(std::string(error.what()).find("317") != std::string::npos);
            CHECK(std::string(error.what()).find('\n') == std::string::npos);
        }
        set.points[3 * 317] = 0.5;
        CHECK(test::check_invariants(test::run(set, options), set.points) == "");
    }

    TEST_CASE("all seeds the same: the first keeps the box") {
        test::PointSet set{"same", {}, std::nullopt};
        for (int i = 0; i < 500; ++i) set.points.insert(set.points.end(), {3, 4, 5});
        const auto t = test::run(set);
        CHECK(test::check_invariants(t, set.points) == "");
        CHECK(t.stats().duplicates == 499);
        CHECK(t.volumes()[0] == doctest::Approx(125).epsilon(1e-14));
        for (std::size_t i = 1; i < 500; ++i) REQUIRE(t.duplicate_of()[i] == 0);
    }

    TEST_CASE("zero and minus zero are the same coordinate") {
        const std::array points{0.0, 0.25, -0.0, 0.5, 0.5, 0.5, -0.0, 0.25, 0.0};
        const auto t = votess::tessellate(points, test::all_options(test::cube(-1, 1)));
        CHECK(test::check_exact(t, points) == "");
        REQUIRE(t.duplicate_of().size() == 3);
        CHECK(t.duplicate_of()[2] == 0);
    }
}

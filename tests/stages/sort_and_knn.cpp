// sort: a permutation near in space, duplicates found; knn: boxes that hold their seeds.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "cpu/search.hpp"
#include "cpu/sort.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"

using votess::ThreadPool;
using votess::cpu::Hierarchy;
using votess::cpu::SeedSorter;
using votess::cpu::SortedSeeds;

namespace {

SortedSeeds sorted_seeds(const test::PointSet& set, ThreadPool& pool, unsigned resolution = 0) {
    SortedSeeds sorted;
    SeedSorter().sort(std::span<const double>(set.points), 1, resolution, pool, sorted);
    return sorted;
}

void check_sorted(const test::PointSet& set, const SortedSeeds& sorted) {
    INFO(set.name);
    // First index of each distinct point, by a different method.
    std::map<std::array<double, 3>, std::int32_t> first;
    std::vector<std::int32_t> kept;
    std::vector<std::int32_t> duplicate_of(set.size(), -1);
    for (std::size_t i = 0; i < set.size(); ++i) {
        const std::array<double, 3> p{set.points[3 * i] + 0.0, set.points[3 * i + 1] + 0.0,
                                      set.points[3 * i + 2] + 0.0};
        const auto [at, is_new] = first.try_emplace(p, static_cast<std::int32_t>(i));
        if (is_new)
            kept.push_back(static_cast<std::int32_t>(i));
        else
            duplicate_of[i] = at->second;
    }
    std::vector<std::int32_t> order(sorted.input.begin(), sorted.input.end());
    std::sort(order.begin(), order.end());
    CHECK(order == kept);
    CHECK(sorted.duplicates == set.size() - kept.size());
    if (sorted.duplicates > 0) CHECK(sorted.duplicate_of == duplicate_of);
    for (std::size_t s = 0; s < sorted.size(); ++s) {
        const auto i = static_cast<std::size_t>(sorted.input[s]);
        REQUIRE(sorted.x[s] == set.points[3 * i]);
        REQUIRE(sorted.y[s] == set.points[3 * i + 1]);
        REQUIRE(sorted.z[s] == set.points[3 * i + 2]);
    }
    CHECK(sorted.x.size() % votess::cpu::group_size == 0);
    for (std::size_t s = sorted.size(); s < sorted.x.size(); ++s) CHECK(std::isinf(sorted.x[s]));
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("sort: every family, sizes across group and crowding limits") {
        ThreadPool pool(2);
        for (std::size_t n : {0, 1, 2, 7, 8, 9, 16, 17, 31, 32, 33, 255, 256, 257}) {
            const auto set = test::uniform(n, n + 1);
            check_sorted(set, sorted_seeds(set, pool));
        }
        for (const auto& set : test::families(600, 5)) check_sorted(set, sorted_seeds(set, pool));
        const auto large = test::uniform(test::by_size(131073, 5000), 3);
        for (unsigned resolution : {0u, 1u, 2u, 3u, 64u, 1u << 20})
            check_sorted(large, sorted_seeds(large, pool, resolution));
    }

    TEST_CASE("sort: many copies of a point in one block, and a signed zero") {
        ThreadPool pool(1);
        test::PointSet set = test::uniform(40, 2);
        set.name = "copies";
        for (int copy = 0; copy < 50; ++copy) set.points.insert(set.points.end(), {0.25, 0.5, 0.75});
        set.points.insert(set.points.end(), {0.0, 0.5, 0.5, -0.0, 0.5, 0.5});
        check_sorted(set, sorted_seeds(set, pool));
    }

    TEST_CASE("sort: neighbors in memory are neighbors in space") {
        ThreadPool pool(1);
        const std::size_t n = 20000;
        const auto set = test::uniform(n, 4);
        const auto sorted = sorted_seeds(set, pool);
        double step = 0;
        for (std::size_t s = 1; s < n; ++s)
            step +=
                std::hypot(sorted.x[s] - sorted.x[s - 1], sorted.y[s] - sorted.y[s - 1], sorted.z[s] - sorted.z[s - 1]);
        // Unsorted, the mean step is 0.66; along a space-filling curve it is about the mean spacing.
        CHECK(step / static_cast<double>(n) < 1.5 / std::cbrt(static_cast<double>(n)));
    }

    TEST_CASE("knn: every box holds its seeds and is held by its parent") {
        ThreadPool pool(2);
        for (std::size_t n : {1, 8, 9, 63, 64, 65, 513, 4097}) {
            const auto set = test::uniform(n, n);
            const auto sorted = sorted_seeds(set, pool);
            Hierarchy hierarchy;
            hierarchy.build(sorted, pool);
            REQUIRE(hierarchy.count(hierarchy.top_level()) == 1);
            for (std::size_t s = 0; s < n; ++s) {
                const double p[3] = {sorted.x[s], sorted.y[s], sorted.z[s]};
                std::size_t node = s / votess::cpu::group_size;
                for (int level = 0; level <= hierarchy.top_level(); ++level, node /= Hierarchy::fan)
                    for (int k = 0; k < 3; ++k) {
                        REQUIRE(hierarchy.box(level, node).lower[k] <= p[k]);
                        REQUIRE(hierarchy.box(level, node).upper[k] >= p[k]);
                    }
            }
        }
    }
}

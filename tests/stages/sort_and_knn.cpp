// sort: a permutation near in space, duplicates found; knn: boxes that hold their seeds.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "cpu/cell_builder.hpp"
#include "index/hilbert.hpp"
#include "index/sort.hpp"
#include "support/allocations.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

using votess::ThreadPool;
using votess::cpu::group_size;
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
    for (const auto* v : {&sorted.x, &sorted.y, &sorted.z}) {
        REQUIRE(v->size() == (sorted.size() + group_size - 1) / group_size * group_size);
        for (std::size_t s = sorted.size(); s < v->size(); ++s)
            CHECK((*v)[s] == std::numeric_limits<double>::infinity());
    }
}

// Large enough for several buckets, parallel tasks and buckets that are split; each unlike the others.
std::vector<test::PointSet> adversaries() {
    const std::size_t n = test::by_size(120001, 40001);
    std::vector<test::PointSet> sets{test::uniform(n, 1), test::clustered(n, 2), test::nested_clusters(n, 3),
                                     test::near_duplicates(n / 4, 4), test::on_axis_line(n, 5)};
    // One cluster that the first grid sees as a point, with copies all over the input.
    test::PointSet tight = test::scaled(test::uniform(n, 6), 1e-12);
    tight.name = "tight cluster";
    for (std::size_t i = 0; i + 7 < n; i += 7) std::copy_n(&tight.points[3 * (i / 70)], 3, &tight.points[3 * (i + 6)]);
    tight.points.insert(tight.points.end(), {1, 1, 1});
    sets.push_back(std::move(tight));
    // Clusters within clusters, the smallest of subnormal extent.
    test::PointSet deep = test::uniform(n, 7);
    deep.name = "down to subnormal";
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            deep.points[3 * i + k] = std::ldexp(deep.points[3 * i + k], -60 * static_cast<int>(i * i % 19));
    sets.push_back(std::move(deep));
    // Few distinct points, each more often than a bucket may be large.
    test::PointSet copies{"copies of five points", {}, test::unit_box()};
    for (std::size_t i = 0; i < n; ++i) {
        const double at = static_cast<double>(i * 7 % 5) / 4;
        copies.points.insert(copies.points.end(), {at, 1 - at, 0.5});
    }
    sets.push_back(std::move(copies));
    // Half of the seeds are copies of others, near and far in the input.
    test::PointSet half = test::uniform(n, 8);
    half.name = "half of them copies";
    for (std::size_t i = 1; i < n; i += 2) std::copy_n(&half.points[3 * (i * i % n)], 3, &half.points[3 * i]);
    sets.push_back(std::move(half));
    return sets;
}

template <class Values>
bool same(const Values& a, const Values& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

bool same_seeds(const SortedSeeds& a, const SortedSeeds& b) {
    return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z) && same(a.input, b.input) &&
           a.duplicate_of == b.duplicate_of && a.duplicates == b.duplicates;
}

// Of the boxes of groups: the median volume, so that a box across empty space does not count.
double group_volume(const SortedSeeds& sorted, ThreadPool& pool) {
    Hierarchy hierarchy;
    hierarchy.build(sorted, pool);
    std::vector<double> volumes;
    for (std::size_t g = 0; g < hierarchy.count(0); ++g) {
        const auto& box = hierarchy.box(0, g);
        volumes.push_back((box.upper[0] - box.lower[0]) * (box.upper[1] - box.lower[1]) *
                          (box.upper[2] - box.lower[2]));
    }
    std::ranges::nth_element(volumes, volumes.begin() + volumes.size() / 2);
    return volumes[volumes.size() / 2];
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

    TEST_CASE("sort: crowds of all kinds, the same order for any number of threads") {
        ThreadPool one(1), two(2), three(3);
        for (const auto& set : adversaries()) {
            const SortedSeeds sorted = sorted_seeds(set, one);
            check_sorted(set, sorted);
            CHECK(same_seeds(sorted, sorted_seeds(set, two)));
            CHECK(same_seeds(sorted, sorted_seeds(set, three)));
        }
    }

    TEST_CASE("sort: reused for other inputs, and without new memory for one of the same size") {
        ThreadPool pool(3);
        SeedSorter sorter;
        SortedSeeds sorted;
        Hierarchy hierarchy;
        for (const auto& set : adversaries())
            for (const std::size_t n : {set.size(), std::size_t{77}, std::size_t{0}, set.size() / 3}) {
                const test::PointSet part{set.name, {set.points.begin(), set.points.begin() + 3 * n}, set.box};
                sorter.sort(std::span<const double>(part.points), 1, 0, pool, sorted);
                hierarchy.build(sorted, pool);
                check_sorted(part, sorted);
                CHECK(same_seeds(sorted, sorted_seeds(part, pool)));
                const double* x = sorted.x.data();
                const auto before = test::allocations();
                sorter.sort(std::span<const double>(part.points), 1, 0, pool, sorted);
                hierarchy.build(sorted, pool);
                CHECK(test::allocations() == before);
                CHECK(sorted.x.data() == x);
            }
    }

    TEST_CASE("sort: floats and a scale") {
        ThreadPool pool(2);
        auto set = test::clustered(test::by_size(50000, 20000), 9);
        const std::vector<float> floats(set.points.begin(), set.points.end());
        std::transform(floats.begin(), floats.end(), set.points.begin(), [](float v) { return v * 0.25; });
        SortedSeeds sorted;
        SeedSorter().sort(std::span<const float>(floats), 0.25, 0, pool, sorted);
        check_sorted(set, sorted);
        CHECK(same_seeds(sorted, sorted_seeds(set, pool)));
    }

    TEST_CASE("sort: blocks that follow each other on the curve share a face, at every scale") {
        constexpr std::uint32_t side = 16;
        constexpr int bits = 12;
        for (int shift = 0; shift <= 6; ++shift) {  // cubes of 16^3 blocks of this size
            std::map<std::uint32_t, std::array<int, 3>> blocks;
            for (std::uint32_t z = 0; z < side; ++z)
                for (std::uint32_t y = 0; y < side; ++y)
                    for (std::uint32_t x = 0; x < side; ++x) {
                        // A point anywhere in the block.
                        const std::uint32_t in = (x + 3 * y + 5 * z) % (1u << shift);
                        const std::uint32_t index =
                            votess::cpu::hilbert_index((x << shift) + in, (y << shift) + in / 2, (z << shift) + in / 3);
                        blocks[index >> 3 * shift] = {static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)};
                    }
            REQUIRE(blocks.size() == 1u << bits);
            CHECK(blocks.rbegin()->first - blocks.begin()->first == (1u << bits) - 1);
            const std::array<int, 3>* last = nullptr;
            for (const auto& [index, block] : blocks) {
                if (last != nullptr)
                    REQUIRE(std::abs(block[0] - (*last)[0]) + std::abs(block[1] - (*last)[1]) +
                                std::abs(block[2] - (*last)[2]) ==
                            1);
                last = &block;
            }
        }
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
        CHECK(group_volume(sorted, pool) * static_cast<double>(n) < 5.2);
    }

    TEST_CASE("sort: clusters that the first grid cannot resolve are as compact as others") {
        ThreadPool pool(2);
        for (const std::size_t n : {3000, 20000}) {  // refined as a block, and as a bucket
            auto set = test::scaled(test::uniform(n, 4), 0x1p-40);
            set.points.insert(set.points.end(), {0, 0, 0, 0, 0, 1});
            const auto sorted = sorted_seeds(set, pool);
            CHECK(group_volume(sorted, pool) * 0x1p120 * static_cast<double>(n) < 5.2);
        }
    }

    TEST_CASE("knn: every box holds its seeds and is held by its parent") {
        ThreadPool pool(2);
        for (const std::size_t n :
             std::initializer_list<std::size_t>{1, 8, 9, 63, 64, 65, 513, 4097, test::by_size(70001, 9001)}) {
            const auto set = test::uniform(n, n);
            const auto sorted = sorted_seeds(set, pool);
            Hierarchy hierarchy;
            hierarchy.build(sorted, pool);
            REQUIRE(hierarchy.count(hierarchy.top_level()) == 1);
            for (std::size_t s = 0; s < n; ++s) {
                const double p[3] = {sorted.x[s], sorted.y[s], sorted.z[s]};
                std::size_t node = s / group_size;
                for (int level = 0; level <= hierarchy.top_level(); ++level, node /= Hierarchy::fan)
                    for (int k = 0; k < 3; ++k) {
                        REQUIRE(hierarchy.box(level, node).lower[k] <= p[k]);
                        REQUIRE(hierarchy.box(level, node).upper[k] >= p[k]);
                    }
            }
        }
    }

    TEST_CASE("knn: no weight exceeds its bound, and linear weights have sharp bounds") {
        ThreadPool pool(2);
        test::Random random(6);
        for (const std::size_t n : std::initializer_list<std::size_t>{1, 7, 8, 9, 16, 17, 25, 64, 65, 129, 513, 4097,
                                                                      test::by_size(20001, 6001)}) {
            for (const std::string kind : {"random", "linear", "smooth", "equal"}) {
                auto sorted = sorted_seeds(test::uniform(n, n), pool);
                sorted.weights.resize(sorted.places(), 0);
                const double offset = random.chance(0.5) ? 0 : 1e6;
                for (std::size_t s = 0; s < n; ++s) {
                    const double x = sorted.x[s], y = sorted.y[s], z = sorted.z[s];
                    sorted.weights[s] = offset + (kind == "random"   ? random.uniform(-1, 1)
                                                  : kind == "linear" ? x - 2 * y + 0.5 * z
                                                  : kind == "smooth" ? std::sin(3 * x) * std::cos(2 * y) + z * z
                                                                     : 0.25);
                }
                std::fill(sorted.weights.begin() + static_cast<std::ptrdiff_t>(n), sorted.weights.end(),
                          sorted.weights[n - 1]);
                Hierarchy hierarchy;
                hierarchy.build(sorted, pool);
                for (std::size_t s = 0; s < n; ++s) {
                    const double p[3] = {sorted.x[s], sorted.y[s], sorted.z[s]};
                    std::size_t node = s / group_size;
                    for (int level = 0; level <= hierarchy.top_level(); ++level, node /= Hierarchy::fan) {
                        const auto& bounds = hierarchy.weight_bounds(level, node / Hierarchy::fan);
                        const std::size_t i = node % Hierarchy::fan;
                        const auto box = hierarchy.box(level, node);
                        double bound = bounds.top[i];
                        for (int k = 0; k < 3; ++k)
                            bound += bounds.slope[k][i] * (p[k] - 0.5 * (box.lower[k] + box.upper[k]));
                        const double rounding = 1e-15 * (offset + 10);
                        REQUIRE(sorted.weights[s] <= bound + rounding);
                        if ((kind == "linear" && n >= 64 && level > 0 && level < hierarchy.top_level()) ||
                            kind == "equal")
                            REQUIRE(bound - sorted.weights[s] < 0.3 + 40 * rounding);
                    }
                }
            }
        }
    }
}

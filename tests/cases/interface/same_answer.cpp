// Order, scale, threads, grid and precision of the input change nothing in the lists.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "support/check.hpp"
#include "support/random.hpp"

namespace {

std::vector<test::PointSet> samples() {
    const std::size_t n = test::by_size(3000, 300);
    return {test::uniform(n, 41),
            test::clustered(n, 42),
            test::nested_clusters(n, 43),
            test::on_walls(n, 44),
            test::with_duplicates(n, n / 20, 45),
            test::cubic(test::by_size(12, 6)),
            test::cubic(7, 0.1),
            test::fcc(8),
            test::cospherical(101),
            test::on_sphere(n / 4, 46),
            test::near_duplicates(n / 2, 47),
            test::on_oblique_line(n / 4, 48)};
}

bool same_rows(const votess::Tessellation& a, const votess::Tessellation& b) {
    return std::equal(a.indptr().begin(), a.indptr().end(), b.indptr().begin(), b.indptr().end()) &&
           std::equal(a.indices().begin(), a.indices().end(), b.indices().begin(), b.indices().end());
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("scaling by powers of two changes no list, and volumes by the cube") {
        for (const test::PointSet& set : samples()) {
            CAPTURE(set.name);
            const auto t = test::run(set);
            for (const double factor : {0x1p-40, 0x1p40, 0x1p-300, 0x1p300}) {
                CAPTURE(factor);
                // With the box that was used: the default one is rounded differently.
                test::PointSet base = set;
                base.box = t.box();
                const auto u = test::run(test::scaled(base, factor));
                CHECK(same_rows(t, u));
                for (std::size_t i = 0; i < t.size(); ++i)
                    REQUIRE(std::abs(u.volumes()[i] / factor / factor / factor - t.volumes()[i]) <=
                            1e-10 * t.volumes()[i]);
            }
        }
    }

    TEST_CASE("shuffling changes no list but for the names") {
        for (const test::PointSet& set : samples()) {
            CAPTURE(set.name);
            const auto t = test::run(set);
            test::Random random(51);
            const auto order = test::permutation(set.size(), random);  // new i is old order[i]
            test::PointSet shuffled{set.name, {}, t.box()};
            for (const std::size_t i : order)
                shuffled.points.insert(shuffled.points.end(),
                                       {set.points[3 * i], set.points[3 * i + 1], set.points[3 * i + 2]});
            const auto u = test::run(shuffled);
            // Among duplicates another one keeps the cell: name each seed by the lowest old index at its place.
            const auto keeper = [&](std::size_t old) {
                const bool is_duplicate = !t.duplicate_of().empty() && t.duplicate_of()[old] >= 0;
                return is_duplicate ? t.duplicate_of()[old] : static_cast<std::int32_t>(old);
            };
            for (std::size_t i = 0; i < set.size(); ++i) {
                if (u.status()[i] == votess::CellStatus::duplicate) continue;
                auto row = test::row_of(u, i);
                for (auto& j : row)
                    if (j >= 0) j = keeper(order[static_cast<std::size_t>(j)]);
                std::sort(row.begin(), row.end());
                const auto old = static_cast<std::size_t>(keeper(order[i]));
                REQUIRE(row == test::row_of(t, old));
                REQUIRE(u.vertex_counts()[i] == t.vertex_counts()[old]);
                REQUIRE(std::abs(u.volumes()[i] - t.volumes()[old]) <= 1e-10 * t.volumes()[old]);
            }
        }
    }

    TEST_CASE("grid_resolution changes no list") {
        for (const test::PointSet& set : samples()) {
            CAPTURE(set.name);
            const auto t = test::run(set);
            for (const unsigned grid : {1u, 2u, 7u, 64u, 1000u}) {
                // One huge block per cell and a thousand empty ones are slow, not wrong.
                if (grid == 1000 && set.size() > 1500) continue;
                CAPTURE(grid);
                votess::Options options = test::all_options();
                options.grid_resolution = grid;
                CHECK(same_rows(t, test::run(set, options)));
            }
        }
    }

    TEST_CASE("float32 input is widened") {
        test::PointSet set = test::uniform(test::by_size(3000, 300), 54);
        std::vector<float> narrow(set.points.begin(), set.points.end());
        set.points.assign(narrow.begin(), narrow.end());
        const auto wide = test::run(set);
        CHECK(test::check_identical(
                  wide, votess::tessellate(std::span<const float>(narrow), test::all_options(set.box))) == "");
        votess::Tessellator tessellator;
        CHECK(test::check_identical(
                  wide, tessellator.tessellate(std::span<const float>(narrow), test::all_options(set.box))) == "");
        // The default box comes from the widened coordinates.
        CHECK(votess::tessellate(std::span<const float>(narrow)).box().upper ==
              votess::tessellate(set.points).box().upper);
    }
}

// Periodic images whose places are rounded: seeds that rounding brings together, and spacings near the rounding of the
// coordinates. Every order of the seeds gives the same cells.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>
#include <votess/votess.hpp>

#include "fuzz/kinds/kinds.hpp"
#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using votess::Options;

votess::Tessellation tessellate(const Coordinates& points, const Options& options) {
    return votess::tessellate(std::span<const double>(points), options);
}

using Face = std::tuple<std::int32_t, int, int, int>;

// The row of a seed by the names that `name` gives to seeds.
std::vector<Face> row_of(const votess::Tessellation& t, std::size_t i, const std::vector<std::size_t>& name) {
    std::vector<Face> row;
    for (auto entry = t.indptr()[i]; entry < t.indptr()[i + 1]; ++entry) {
        const std::int32_t id = t.indices()[static_cast<std::size_t>(entry)];
        std::array<int, 3> shift{};
        for (std::size_t k = 0; k < 3 && !t.shifts().empty(); ++k)
            shift[k] = t.shifts()[3 * static_cast<std::size_t>(entry) + k];
        row.emplace_back(id < 0 ? id : static_cast<std::int32_t>(name[static_cast<std::size_t>(id)]), shift[0],
                         shift[1], shift[2]);
    }
    std::ranges::sort(row);
    return row;
}

// "" when the set is right in its own order, and in all others the same.
std::string check_in_every_order(const test::fuzz::Job& job) {
    const std::size_t n = job.size();
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    const Options options = job.options("cpu");
    const auto first = tessellate(job.points, options);
    if (auto failure = test::check_domain(first); !failure.empty()) return failure;
    if (first.stats().duplicates > 0) return "";  // which of them has the cell depends on the order
    if (auto failure = test::check_against_half_spaces(first, job.points, options); !failure.empty()) return failure;
    std::vector<std::vector<Face>> rows;
    for (std::size_t i = 0; i < n; ++i) rows.push_back(row_of(first, i, order));
    while (std::ranges::next_permutation(order).found) {
        test::fuzz::Job other = job;
        for (std::size_t i = 0; i < n; ++i) {
            std::copy_n(job.points.begin() + static_cast<std::ptrdiff_t>(3 * order[i]), 3,
                        other.points.begin() + static_cast<std::ptrdiff_t>(3 * i));
            if (!job.weights.empty()) other.weights[i] = job.weights[order[i]];
        }
        const auto t = tessellate(other.points, other.options("cpu"));
        for (std::size_t i = 0; i < n; ++i)
            if (row_of(t, i, order) != rows[order[i]]) return "the row of a seed depends on the order of seeds";
    }
    return "";
}

Options unit_box_options(bool periodic) {
    Options options;
    options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
    options.periodic = {periodic, periodic, periodic};
    options.want = {.neighbors = true, .volumes = true};
    options.threads = 1;
    return options;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("images: a wrapped seed that rounds onto another keeps its own cell") {
        const double a = -0.3492714367344718, b = 1.527212794076232;
        Options options = test::all_options(votess::Box{{-0.23936944299295215, 0, 0}, {1.6371147878177517, 1, 1}});
        options.periodic = {true, false, false};
        for (const Coordinates& points :
             {Coordinates{a, 0.5, 0.5, b, 0.5, 0.5}, Coordinates{b, 0.5, 0.5, a, 0.5, 0.5}}) {
            const auto t = tessellate(points, options);
            CHECK(t.stats().duplicates == 0);
            CHECK(test::check_domain(t) == "");
            CHECK(test::check_against_half_spaces(t, points, options) == "");
        }
    }

    TEST_CASE("images: seeds and their rounded translations, in every order") {
        // VOTESS_WRAPPED_SETS: how many.
        const std::uint64_t sets = test::environment("VOTESS_WRAPPED_SETS", test::by_size(150, 15));
        const std::uint64_t seed = test::environment("VOTESS_FUZZ_SEED", 1);
        for (std::uint64_t number = seed, tried = 0; tried < sets; ++number) {
            test::Random random(number);
            for (const test::fuzz::Job& job : test::fuzz::wrapped_pairs(random)) {
                if (job.size() > 4) continue;
                ++tried;
                CAPTURE(number);
                REQUIRE(check_in_every_order(job) == "");
            }
        }
    }

    TEST_CASE("images: clusters beside a periodic face at spacings down to the rounding of coordinates") {
        const std::size_t sets = test::by_size(200, 20);
        for (std::size_t n = 0; n < sets; ++n) {
            test::Random random(n + 1);
            const double spacing = std::pow(10.0, -8 - 6 * random.uniform());
            Coordinates points;
            const std::array<double, 3> center{1 - 2 * spacing * random.uniform(), random.below(2) == 0 ? 0.5 : 0.0,
                                               0.5};
            for (std::size_t i = 0; i < 120; ++i)
                for (const double x : center) points.push_back(x + 3 * spacing * random.gaussian());
            for (int i = 0; i < 30; ++i) points.push_back(random.uniform());
            const auto t = tessellate(points, unit_box_options(true));
            CAPTURE(n);
            REQUIRE(test::check_domain(t) == "");
            REQUIRE(votess::verify(t, points).failure == "");
        }
    }

    TEST_CASE("images: power diagrams whose weights are far above the squared spacing, full of near-ties") {
        const std::size_t sets = test::by_size(200, 20);
        for (std::size_t n = 0; n < sets; ++n) {
            test::Random random(n + 1);
            // A crowd around 0, and a few heavy seeds at distances that nearly touch its cells.
            const double spacing = std::pow(10.0, -3 - 4 * random.uniform()), most = 0.3 + random.uniform();
            Coordinates points;
            std::vector<double> weights;
            for (std::size_t i = 0; i < 100; ++i) {
                for (int k = 0; k < 3; ++k) points.push_back(spacing * random.gaussian());
                weights.push_back(0);
            }
            for (std::size_t i = 0; i < 12; ++i) {
                std::array<double, 3> u;
                double length = 0;
                for (double& x : u) x = random.gaussian(), length += x * x;
                const double weight = most * random.uniform(0.2, 1);
                // The bisector with 0 passes 0 at some spacings.
                const double distance = std::sqrt(weight) * (1 + spacing * random.uniform(0, 2));
                for (const double x : u) points.push_back(x / std::sqrt(length) * distance);
                weights.push_back(weight);
            }
            Options options = unit_box_options(false);
            options.box = votess::Box{{-2, -2, -2}, {2, 2, 2}};
            options.weights = weights;
            const auto t = tessellate(points, options);
            CAPTURE(n);
            REQUIRE(test::check_domain(t) == "");
            REQUIRE(votess::verify(t, points).failure == "");
        }
    }

    // Rows without normals were read from behind the seeds.
    TEST_CASE("images: in a skewed cell an image may have no shift, beside seeds that have none") {
        Options options;
        options.device = "cpu";
        options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {7.3, 5.2, 1}, {true, true, true}};
        options.threads = 1;
        Options with_normals = options;
        with_normals.want.normals = true;
        for (std::uint64_t n = 1; n <= 3; ++n) {
            const Coordinates points = test::uniform(test::by_size(2000, 500), n).points;
            const auto t = tessellate(points, options), same = tessellate(points, with_normals);
            CHECK(std::ranges::equal(t.indptr(), same.indptr()));
            CHECK(std::ranges::equal(t.indices(), same.indices()));
            CHECK(std::ranges::equal(t.shifts(), same.shifts()));
        }
    }
}

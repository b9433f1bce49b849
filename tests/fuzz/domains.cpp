// Random domains with few seeds, full of ties, against exact half-spaces. VOTESS_FUZZ_DOMAINS sets, from
// VOTESS_FUZZ_SEED on.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>
#include <votess/votess.hpp>

#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;

struct Case {
    Coordinates points;
    std::vector<double> weights;
    votess::Options options;
    int reach = 0;
};

// A coordinate in 0 .. 1: any, or a step of a coarse grid, or a hair beside one.
double coordinate(test::Random& random, std::uint64_t kind, int steps) {
    if (kind == 0) return random.uniform(0, 1);
    const double step = static_cast<double>(random.below(static_cast<std::uint64_t>(steps))) / steps;
    if (kind == 1 || random.below(3) > 0) return step;
    return std::clamp(step + random.uniform(-1, 1) * 1e-15, 0.0, 1.0);
}

Case random_case(std::uint64_t seed) {
    test::Random random(seed);
    Case c;
    c.options = test::all_options(test::unit_box());
    const auto kind = random.below(3);
    const int steps = 2 + static_cast<int>(random.below(4));
    const std::size_t n = 1 + random.below(7);
    const auto domain = random.below(4);
    if (domain == 1 || domain == 2) c.reach = domain == 1 ? 2 : 3;
    if (domain == 1)
        for (bool& axis : c.options.periodic) axis = random.below(2) == 0;
    if (domain == 2) {
        votess::TriclinicBox cell{{}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (double* x : {&cell.b[0], &cell.c[0], &cell.c[1]})
            *x = kind == 0 ? random.uniform(-0.5, 0.5) : (static_cast<double>(random.below(3)) - 1) / 2;
        c.options.box.reset();
        c.options.cell = cell;
    }
    while (c.points.size() < 3 * n) {
        std::array<double, 3> x{};
        for (double& value : x) value = coordinate(random, kind, steps);
        c.points.insert(c.points.end(), x.begin(), x.end());
    }
    // Here and there a seed next to another, by the smallest step there is.
    for (std::size_t i = 1; i < n && random.below(2) == 0; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            c.points[3 * i + k] = std::nextafter(c.points[3 * i + k - 3], static_cast<double>(random.below(2)));
    if (random.below(2) == 0)
        for (std::size_t i = 0; i < n; ++i)
            c.weights.push_back(kind == 0 ? random.uniform(-0.1, 0.3)
                                          : static_cast<double>(random.below(4)) / (2.0 * steps * steps));
    if (domain == 3)
        for (std::uint64_t w = 1 + random.below(3); w > 0; --w) {
            votess::Wall wall{};
            for (double& x : wall.normal)
                x = kind == 0 ? random.uniform(-1, 1) : static_cast<double>(random.below(3)) - 1;
            if (wall.normal == std::array<double, 3>{}) wall.normal[0] = 1;
            // Through a seed, or where no seed is outside.
            double farthest = -1e9;
            for (std::size_t i = 0; i < n; ++i) {
                double at = 0;
                for (std::size_t k = 0; k < 3; ++k) at += wall.normal[k] * c.points[3 * i + k];
                farthest = std::max(farthest, at);
            }
            wall.offset = farthest + (kind == 0 ? 0.1 : 0.25);
            c.options.walls.push_back(wall);
        }
    return c;
}

}  // namespace

TEST_SUITE("fuzz") {
    TEST_CASE("fuzz: random domains against exact half-spaces") {
        const std::uint64_t sets = test::environment("VOTESS_FUZZ_DOMAINS", test::by_size(30, 6));
        const std::uint64_t first = test::environment("VOTESS_FUZZ_SEED", 1);
        std::uint64_t tried = 0;
        for (std::uint64_t seed = first; seed < first + sets; ++seed) {
            Case c = random_case(seed);
            c.options.weights = c.weights;
            CAPTURE(seed);
            const auto t = votess::tessellate(std::span<const double>(c.points), c.options);
            REQUIRE(test::check_domain(t) == "");
            REQUIRE(votess::verify(t, c.points).failure == "");
            // Rows of seeds at one place depend on which of them has the cell.
            if (t.stats().duplicates > 0) continue;
            ++tried;
            REQUIRE(test::check_against_half_spaces(t, c.points, c.options, c.reach) == "");
        }
        CHECK(tried > sets / 3);
    }
}

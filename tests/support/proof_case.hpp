// Sets for tests of verify().
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>
#include <votess/votess.hpp>

#include "support/generators.hpp"
#include "support/random.hpp"

namespace test {

// A run whose results are proven, and damaged: small sets in all kinds of domains.
struct ProofCase {
    Coordinates points;
    std::vector<double> weights;
    votess::Options options;  // without weights
    double spacing = 0;

    [[nodiscard]] votess::Tessellation run() const {
        votess::Options with = options;
        with.weights = weights;
        return votess::tessellate(std::span<const double>(points), with);
    }
};

inline constexpr int proof_domains = 11;

inline void make_case(int domain, Random& random, ProofCase& c) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const std::size_t n = 4 + random.below(28);
    c.options.device = "cpu";
    c.options.threads = 1;
    c.options.list_walls = random.chance(0.5);
    Coordinates sides{1, 1, 1};
    if (random.chance(0.3)) sides = {1, 0.3, 0.1};
    if (domain == 7) sides = {1, 0.01, 0.03};
    if (domain < 3 || domain == 4 || domain == 5 || domain == 7) {
        c.options.box = votess::Box{{0, 0, 0}, {sides[0], sides[1], sides[2]}};
        const bool all = domain == 1 || domain == 5 || domain == 7;
        c.options.periodic = {all, all || domain == 2, all};
    }
    if (domain == 3) c.options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.7, 0.8}};
    if (domain == 3) c.options.cell->periodic = {true, random.chance(0.7), true};
    if (domain == 4) c.options.walls = {{{1, 1, 1}, 0.8 * (sides[0] + sides[1] + sides[2])}, {{-1, 2, 0.5}, 1.1}};
    if (domain == 6 || domain == 8) c.options.box = votess::Box{{0.2, 0.2, 0.2}, {0.7, 0.8, 0.9}};
    if (domain == 6) c.options.outside = votess::Outside::keep;
    if (domain == 3 || domain == 4 || domain == 8) c.options.outside = votess::Outside::drop;
    if (domain == 9) c.options.planar = true, c.options.box = votess::Box{{0, 0, 0}, {1, 1, 0}};
    if (domain == 10) c.options.box = cube(-inf, inf);
    const std::size_t dimensions = c.options.planar ? 2 : 3;
    if (domain == 5) {  // a lattice, with or without errors
        const double jitter = std::array{0.0, 1e-14, 1e-4}[random.below(3)];
        for (int k = 0; k < 27; ++k)
            for (const int at : {k % 3, k / 3 % 3, k / 9})
                c.points.push_back(sides[c.points.size() % 3] *
                                   ((at + 0.25) / 4 * (1 + (random.chance(0.5) ? jitter : 0))));
    } else {
        for (std::size_t k = 0; k < dimensions * n; ++k) c.points.push_back(sides[k % dimensions] * random.uniform());
    }
    const std::size_t count = c.points.size() / dimensions;
    c.spacing = std::cbrt(sides[0] * sides[1] * sides[2] / static_cast<double>(count));
    if (random.chance(0.4))
        for (std::size_t i = 0; i < count; ++i) c.weights.push_back(random.uniform(0, 0.7 * c.spacing * c.spacing));
    if (random.chance(0.2))
        for (std::size_t k = 0; k < dimensions; ++k) c.points[dimensions + k] = c.points[k];  // a duplicate
}

}  // namespace test

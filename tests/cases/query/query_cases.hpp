// Small random diagrams in every domain, half of them on a grid where cells meet in ties, and queries that like to lie
// where it matters.
#pragma once

#include <array>
#include <vector>
#include <votess/votess.hpp>

#include "oracle/integer_domain.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace test {

struct QueryCase {
    Coordinates points;
    std::vector<double> weights;
    votess::Options options;
};

inline QueryCase random_query_case(Random& random, bool grid) {
    QueryCase c;
    const auto coordinate = [&] { return grid ? static_cast<double>(random.below(5)) / 4 : random.uniform(); };
    const auto domain = random.below(5);
    c.options.box = unit_box();
    c.options.threads = 1;
    if (domain == 1)
        for (bool& axis : c.options.periodic) axis = random.below(3) > 0;
    if (domain == 2 || domain == 3) {
        votess::TriclinicBox cell{{}, {1, 0, 0}, {grid ? 0.5 : 0.4, 1, 0}, {grid ? -0.25 : -0.3, 0.25, 1}};
        if (domain == 3) cell.periodic[random.below(3)] = false;
        c.options.box.reset();
        c.options.cell = cell;
    }
    const std::size_t n = 1 + random.below(12);
    while (c.points.size() < 3 * n) {
        const double f[3] = {coordinate(), coordinate(), coordinate()};
        for (std::size_t k = 0; k < 3; ++k) {
            if (!c.options.cell) {
                c.points.push_back(f[k]);
                continue;
            }
            const auto& cell = *c.options.cell;
            c.points.push_back(f[0] * cell.a[k] + f[1] * cell.b[k] + f[2] * cell.c[k]);
        }
    }
    if (domain == 4) {
        votess::Wall wall{{1, 2, grid ? 0.0 : 0.7}, 2};
        c.options.walls.push_back(wall);
    }
    c.options.outside = votess::Outside::drop;
    if (random.below(2) == 0)
        for (std::size_t i = 0; i < n; ++i)
            c.weights.push_back(grid ? static_cast<double>(random.below(4)) / 16 : random.uniform(-0.1, 0.3));
    return c;
}

// Anywhere, on a grid of eighths, on a seed, between two of them, and in a periodic domain up to a period away.
inline std::array<double, 3> random_query(Random& random, const QueryCase& c, bool repeats) {
    std::array<double, 3> x;
    const auto kind = random.below(4);
    const std::size_t i = random.below(c.points.size() / 3), j = random.below(c.points.size() / 3);
    for (std::size_t k = 0; k < 3; ++k) {
        if (kind == 0) x[k] = random.uniform(-0.1, 1.1);
        if (kind == 1) x[k] = static_cast<double>(random.below(9)) / 8;
        if (kind == 2) x[k] = c.points[3 * i + k];
        if (kind == 3) x[k] = 0.5 * (c.points[3 * i + k] + c.points[3 * j + k]);
        if (repeats && random.below(4) == 0) x[k] += static_cast<double>(random.integer(-1, 1));
    }
    return x;
}

// Returns the domain of the case with one more seed, the last one, of weight 0.
inline IntegerDomain with_query(const QueryCase& c, const double* query) {
    Coordinates points = c.points;
    points.insert(points.end(), query, query + 3);
    std::vector<double> weights = c.weights;
    if (!weights.empty()) weights.push_back(0);
    votess::Options options = c.options;
    options.weights = weights;
    return IntegerDomain(points, options);
}

}  // namespace test

// Diagram::locate() against exact arithmetic with every seed and image.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>
#include <votess/diagram.hpp>

#include "cases/query/query_cases.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using Case = test::QueryCase;
// Returns the seed of the least power distance, the lowest of equal ones; -1 for a query outside the domain.
std::int32_t nearest(const Case& c, const double* query) {
    const test::IntegerDomain domain = test::with_query(c, query);
    const std::size_t q = domain.size() - 1;
    if (domain.is_outside(q)) return -1;
    std::int32_t best = -1;
    mpz_class least;
    for (std::size_t i = 0; i < q; ++i) {
        if (domain.is_outside(i)) continue;
        for (const auto& shift : domain.near_shifts(q, i)) {
            const mpz_class power = domain.bisector(q, i, shift).h;  // the query has no weight
            if (best < 0 || power < least) least = power, best = static_cast<std::int32_t>(i);
        }
    }
    return best;
}

std::vector<std::int32_t> nearest_by_distance(const Coordinates& points, const Coordinates& queries) {
    std::vector<std::int32_t> nearest;
    for (std::size_t q = 0; q < queries.size(); q += 3) {
        double least = std::numeric_limits<double>::infinity();
        std::int32_t best = -1;
        for (std::size_t i = 0; i < points.size(); i += 3) {
            double square = 0;
            for (std::size_t k = 0; k < 3; ++k)
                square += (points[i + k] - queries[q + k]) * (points[i + k] - queries[q + k]);
            if (square < least) least = square, best = static_cast<std::int32_t>(i / 3);
        }
        nearest.push_back(best);
    }
    return nearest;
}

}  // namespace

TEST_SUITE("query") {
    TEST_CASE("locate: random domains and queries against exact arithmetic") {
        test::Random random(7);
        for (std::size_t set = 0; set < test::by_size(200, 30); ++set) {
            CAPTURE(set);
            Case c = test::random_query_case(random, set % 2 == 0);
            c.options.weights = c.weights;
            const votess::Diagram diagram(c.points, c.options);
            const auto& periodic = c.options.cell ? c.options.cell->periodic : c.options.periodic;
            Coordinates queries;
            for (int q = 0; q < 10; ++q) {
                const auto x = test::random_query(random, c, periodic == std::array{true, true, true});
                queries.insert(queries.end(), x.begin(), x.end());
            }
            const auto found = diagram.locate(queries);
            REQUIRE(found.size() == queries.size() / 3);
            for (std::size_t q = 0; q < found.size(); ++q) {
                CAPTURE(q);
                REQUIRE(found[q] == nearest(c, &queries[3 * q]));
            }
        }
    }

    TEST_CASE("locate: faces, edges and vertices of a lattice belong to the lowest seed") {
        constexpr int side = 6;
        Coordinates points, queries;
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) points.insert(points.end(), {x + 0.5, y + 0.5, z + 0.5});
        votess::Options options;
        options.box = votess::Box{{0, 0, 0}, {side, side, side}};
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            options.periodic = {periodic, periodic, periodic};
            const votess::Diagram diagram(points, options);
            queries.clear();
            std::vector<std::int32_t> expected;
            for (int z = 0; z <= 2 * side; ++z)
                for (int y = 0; y <= 2 * side; ++y)
                    for (int x = 0; x <= 2 * side; ++x) {
                        queries.insert(queries.end(), {x / 2.0, y / 2.0, z / 2.0});
                        // Two cells meet at a whole number, and the lower one has it; across the box's faces seed 0
                        // has.
                        const auto lowest = [&](int twice) {
                            if (twice % 2 == 1) return twice / 2;
                            if (twice == 0 || twice == 2 * side) return periodic || twice == 0 ? 0 : side - 1;
                            return twice / 2 - 1;
                        };
                        expected.push_back((lowest(z) * side + lowest(y)) * side + lowest(x));
                    }
            CHECK(diagram.locate(queries) == expected);
        }
    }

    TEST_CASE("locate: many seeds and queries against all distances") {
        const std::size_t n = test::by_size(3000, 600);
        test::Random random(3);
        Coordinates queries;
        for (std::size_t i = 0; i < 3 * n; ++i) queries.push_back(random.uniform());
        votess::Options options;
        options.box = test::unit_box();
        for (const auto& set : {test::uniform(n, 5), test::clustered(n, 6)}) {
            const votess::Diagram diagram(set.points, options);
            CHECK(diagram.size() == set.points.size() / 3);
            CHECK(diagram.locate(queries) == nearest_by_distance(set.points, queries));
        }
    }

    // Images that lie farther than those among the seeds; and a weight that reaches everywhere.
    TEST_CASE("locate: voids of periodic boxes, and one heavy seed") {
        test::Random random(11);
        for (int set = 0; set < 6; ++set) {
            CAPTURE(set);
            Case c;
            c.options.box = test::unit_box();
            c.options.periodic = {true, true, set % 2 == 0};
            for (std::size_t i = 0; i < 3 * test::by_size(60, 30); ++i)
                c.points.push_back(0.8 + 0.01 * random.gaussian() * (set < 3 ? 1 : 0.01));
            if (set % 3 == 2) {
                c.weights.assign(c.points.size() / 3, 0.0);
                c.weights[7] = 0.04;
            }
            c.options.weights = c.weights;
            const votess::Diagram diagram(c.points, c.options);
            Coordinates queries;
            for (int q = 0; q < 30; ++q)
                for (int k = 0; k < 3; ++k) queries.push_back(random.uniform());
            const auto found = diagram.locate(queries);
            for (std::size_t q = 0; q < found.size(); ++q) CHECK(found[q] == nearest(c, &queries[3 * q]));
        }
    }

    TEST_CASE("locate: no seeds, duplicates, and what is refused") {
        CHECK(votess::Diagram().locate(Coordinates{0, 0, 0}) == std::vector<std::int32_t>{-1});
        CHECK(votess::Diagram().size() == 0);
        votess::Options options;
        options.box = test::unit_box();
        const Coordinates points{0.25, 0.5, 0.5, 0.75, 0.5, 0.5, 0.25, 0.5, 0.5};
        const votess::Diagram diagram(points, options);
        CHECK(diagram.locate(std::vector<double>{}).empty());
        CHECK(diagram.locate(Coordinates{0.2, 0.5, 0.5, 0.8, 0.5, 0.5, 1.5, 0.5, 0.5, 0.5, 1, 0}) ==
              std::vector<std::int32_t>{0, 1, -1, 0});
        const std::vector<double> weights{0, 0, 1};  // the heavier of two at one place has the cell
        options.weights = weights;
        CHECK(votess::Diagram(points, options).locate(points) == std::vector<std::int32_t>{2, 2, 2});
        options.weights = {};

        const auto refusal = [](const auto& call) {
            std::string message;
            CHECK(test::error_of(call, &message));
            return message;
        };
        const double nan = std::numeric_limits<double>::quiet_NaN();
        CHECK(refusal([&] { (void)diagram.locate(Coordinates{0, 0, 0, 0, nan, 0}); }).find("query 1") == 0);
        CHECK(refusal([&] { (void)diagram.locate(Coordinates{0, 0}); }).find("shape") != std::string::npos);
        options.device = "gpu";
        CHECK(refusal([&] { votess::Diagram(points, options); }).find("CPU") != std::string::npos);
        options.device = "auto";
        options.min_face = 0.1;
        CHECK(refusal([&] { votess::Diagram(points, options); }).find("Options::min_face") == 0);
        options.min_face = 0;
        options.periodic = {true, true, true};
        const votess::Diagram periodic(points, options);
        CHECK(periodic.locate(Coordinates{1e6 + 0.25, -3.5, 0.5}) == std::vector<std::int32_t>{0});
        CHECK(refusal([&] { (void)periodic.locate(Coordinates{1e300, 0, 0}); }).find("query 0") == 0);
    }
}

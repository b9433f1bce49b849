// Natural-neighbor coordinates against rational arithmetic, where topology is hard: ties, walls, buried seeds, close
// pairs.
#include "oracle/shares.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>
#include <votess/diagram.hpp>

#include "cases/query/query_cases.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using test::QueryCase;
using test::Random;

constexpr double max_error = 1e-12;

double power_of_ten(Random& random, double lower, double upper) {
    return std::pow(10.0, random.uniform(lower, upper));
}

double rounded(double x) {
    return std::round(x * 0x1p10) * 0x1p-10;
}

// Keeps the seeds inside the domain, one at each place.
QueryCase without_duplicates(const QueryCase& c) {
    votess::Options options = c.options;
    options.weights = c.weights;
    const auto t = votess::tessellate(c.points, options);
    QueryCase kept = c;
    kept.points.clear();
    kept.weights.clear();
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (t.status()[i] == votess::CellStatus::duplicate || t.status()[i] == votess::CellStatus::outside) continue;
        kept.points.insert(kept.points.end(), &c.points[3 * i], &c.points[3 * i] + 3);
        if (!c.weights.empty()) kept.weights.push_back(c.weights[i]);
    }
    return kept;
}

// Seeds of random_query_case(), or instead of them a lattice or a slightly shaken one; some have a close companion.
QueryCase hard_case(Random& random) {
    QueryCase c = test::random_query_case(random, random.below(2) == 0);
    const auto kind = random.below(6);
    if (kind <= 1 && !c.options.cell && c.options.walls.empty()) {
        c.points.clear();
        const double shaken = random.below(2) == 0 ? 0 : power_of_ten(random, -16, -4);
        for (int i = 0; i < 8; ++i)
            for (const double half : {0.0, 0.25}) {
                if (kind == 0 && half > 0) continue;
                for (const int axis : {i & 1, i >> 1 & 1, i >> 2})
                    c.points.push_back(axis * 0.5 + half + 0.125 + shaken * random.uniform(-1, 1));
            }
    }
    if (kind == 2)
        for (std::size_t i = 0; i < 2 && 3 * i < c.points.size(); ++i) {
            const double apart = power_of_ten(random, -15, -4);
            for (std::size_t k = 0; k < 3; ++k)
                c.points.push_back(std::clamp(c.points[3 * i + k] + apart * random.uniform(-1, 1), 0.0, 0.9));
        }
    // Short numbers keep rational arithmetic fast.
    if (kind > 2)
        for (double& x : c.points) x = rounded(x);
    if (!c.weights.empty()) c.weights.resize(c.points.size() / 3, 0.1);
    return without_duplicates(c);
}

// As random_query() with short numbers, or near a seed.
std::array<double, 3> hard_query(Random& random, const QueryCase& c) {
    std::array<double, 3> x;
    if (random.below(6) > 0) {
        x = test::random_query(random, c, false);
        for (double& coordinate : x) coordinate = rounded(coordinate);
        return x;
    }
    const std::size_t i = random.below(c.points.size() / 3);
    const double apart = power_of_ten(random, -13, -1);
    for (std::size_t k = 0; k < 3; ++k) x[k] = c.points[3 * i + k] + apart * random.uniform(-1, 1);
    return x;
}

struct Row {
    std::vector<std::int32_t> seeds;
    std::vector<double> weights, gradients;
};
Row row_of(const votess::NaturalCoordinates& c, std::size_t q) {
    const auto begin = c.indptr[q], end = c.indptr[q + 1];
    Row row;
    row.seeds.assign(c.indices.begin() + begin, c.indices.begin() + end);
    row.weights.assign(c.weights.begin() + begin, c.weights.begin() + end);
    if (!c.gradients.empty()) row.gradients.assign(c.gradients.begin() + 3 * begin, c.gradients.begin() + 3 * end);
    return row;
}

// Returns what is wrong with a row; expected: by seed, those that are positive.
std::string check_weights(const Row& row, const std::map<std::int32_t, double>& expected) {
    double sum = 0;
    if (row.seeds.size() != expected.size())
        return std::to_string(row.seeds.size()) + " seeds for " + std::to_string(expected.size());
    std::size_t e = 0;
    for (const auto& [seed, weight] : expected) {
        if (row.seeds[e] != seed) return "lacks seed " + std::to_string(seed);
        if (!(row.weights[e] > 0)) return "seed " + std::to_string(seed) + " has no positive weight";
        if (!(std::abs(row.weights[e] - weight) <= max_error))
            return "the weight of seed " + std::to_string(seed) + " is wrong by " +
                   std::to_string(std::abs(row.weights[e] - weight) * 1e12) + "e-12";
        sum += row.weights[e++];
    }
    // A query that buries all seeds has no face with any.
    if (!expected.empty() && !(std::abs(sum - 1) <= max_error)) return "weights do not sum to 1";
    return "";
}

std::string check_sibson(const Row& row, const test::Shares& exact) {
    std::map<std::int32_t, double> expected;
    std::array<mpq_class, 3> sum;
    for (const auto& [seed, share] : exact.of) {
        if (share.volume > 0) expected[seed] = mpq_class(share.volume / exact.volume).get_d();
        for (std::size_t k = 0; k < 3; ++k) sum[k] += share.gradient[k];
    }
    if (const std::string wrong = check_weights(row, expected); !wrong.empty()) return wrong;
    const double size = std::cbrt(exact.volume.get_d());
    for (std::size_t e = 0; e < row.gradients.size() / 3; ++e) {
        const test::Shares::Share& share = exact.of.at(row.seeds[e]);
        std::array<double, 3> slope;
        double steepest = 1 / size;
        for (std::size_t k = 0; k < 3; ++k) {
            slope[k] = mpq_class((share.gradient[k] - share.volume / exact.volume * sum[k]) / exact.volume).get_d();
            steepest = std::max(steepest, std::abs(slope[k]));
        }
        for (std::size_t k = 0; k < 3; ++k)
            if (!(std::abs(row.gradients[3 * e + k] - slope[k]) <= 1e-6 * steepest))
                return "the gradient of seed " + std::to_string(row.seeds[e]) + " is wrong by " +
                       std::to_string(std::abs(row.gradients[3 * e + k] - slope[k]) / steepest);
    }
    return "";
}

std::string check_laplace(const Row& row, const test::Shares& exact) {
    std::map<std::int32_t, double> expected;
    double sum = 0;
    for (const auto& [seed, share] : exact.of) sum += share.area;
    for (const auto& [seed, share] : exact.of)
        if (share.area > 0) expected[seed] = share.area / sum;
    return check_weights(row, expected);
}

}  // namespace

TEST_SUITE("shares") {
    TEST_CASE("shares: queries against rational arithmetic") {
        Random random(20);
        const std::size_t wanted = test::by_size(200, 30);
        std::size_t checked = 0, buried = 0, at_walls = 0, periodic = 0;
        for (int number = 0; checked < wanted; ++number) {
            CAPTURE(number);
            const QueryCase c = hard_case(random);
            if (c.points.empty()) continue;
            votess::Options options = c.options;
            options.weights = c.weights;
            const votess::Diagram diagram(c.points, options);
            for (int q = 0; q < 8; ++q) {
                CAPTURE(q);
                const auto x = hard_query(random, c);
                votess::NaturalOptions sibson, laplace;
                sibson.gradients = true;
                laplace.method = votess::NaturalMethod::laplace;
                std::vector<double> weight;
                if (!c.weights.empty()) weight.push_back(random.below(3) == 0 ? 0 : random.uniform(-0.2, 0.6));
                sibson.weights = laplace.weights = weight;
                Row row, areas;
                bool refused = false;
                try {
                    row = row_of(diagram.natural_neighbors(x, sibson), 0);
                    areas = row_of(diagram.natural_neighbors(x, laplace), 0);
                } catch (const votess::Error& error) {
                    REQUIRE(error.code() == votess::ErrorCode::unsupported);
                    refused = true;
                }
                const std::int32_t nearest = diagram.locate(x)[0];
                if (nearest < 0) {
                    CHECK(row.seeds.empty());
                    continue;
                }
                if (!row.gradients.empty() && std::isnan(row.gradients[0])) {
                    CHECK((!c.weights.empty() || row.seeds == std::vector{nearest}));
                    continue;
                }
                const auto exact =
                    test::exact_shares(c.points, c.weights, c.options, x, weight.empty() ? 0 : weight[0]);
                ++checked;
                if (exact.volume == 0) {
                    CHECK(row.seeds.empty());
                    continue;
                }
                CHECK(refused == exact.meets_itself);
                if (refused || exact.meets_itself) continue;
                CHECK(check_sibson(row, exact) == "");
                CHECK(check_laplace(areas, exact) == "");
                at_walls += exact.at_wall ? 1 : 0;
                periodic += diagram.size() > 0 && (c.options.periodic[0] || c.options.cell) ? 1 : 0;
                buried += areas.seeds.size() < row.seeds.size() ? 1 : 0;
            }
        }
        CHECK(buried >= wanted / 40);
        CHECK(at_walls > wanted / 4);
        CHECK(periodic > wanted / 10);
    }

    TEST_CASE("shares: the bisector of two seeds meets an edge of the domain") {
        votess::Options options;
        options.box = test::unit_box();
        const votess::Diagram diagram(Coordinates{0, 0, 0, 0, 1, 0, 1, 1, 0}, options);
        const Row row = row_of(diagram.natural_neighbors(Coordinates{0.6141, 0.1592, 0.8754}), 0);
        REQUIRE(row.seeds.size() == 3);
        CHECK(row.weights[0] == doctest::Approx(0.451563).epsilon(1e-5));
        CHECK(row.weights[1] == doctest::Approx(0.167306).epsilon(1e-5));
        CHECK(row.weights[2] == doctest::Approx(0.381131).epsilon(1e-5));
    }

    // The graph of all vertices answers many queries at once.
    TEST_CASE("shares: many queries among many seeds") {
        Random random(21);
        for (const bool weighted : {false, true}) {
            CAPTURE(weighted);
            QueryCase c;
            c.points = test::uniform(64, weighted ? 22 : 23).points;
            for (int i = 0; i < 64 && weighted; ++i) c.weights.push_back(random.uniform(0, 0.02));
            c.options.box = test::unit_box();
            votess::Options options = c.options;
            options.weights = c.weights;
            const votess::Diagram diagram(c.points, options);
            const std::size_t count = 32;
            Coordinates queries;
            for (std::size_t i = 0; i < 3 * count; ++i) queries.push_back(random.uniform());
            std::vector<double> weights;
            for (std::size_t i = 0; i < count && weighted; ++i) weights.push_back(random.uniform(0, 0.05));
            votess::NaturalOptions sibson;
            sibson.gradients = true;
            sibson.weights = weights;
            const auto found = diagram.natural_neighbors(queries, sibson);
            for (std::size_t q = 0; q < count; ++q) {
                CAPTURE(q);
                const auto exact = test::exact_shares(c.points, c.weights, c.options,
                                                      {queries[3 * q], queries[3 * q + 1], queries[3 * q + 2]},
                                                      weighted ? weights[q] : 0);
                CHECK(check_sibson(row_of(found, q), exact) == "");
            }
        }
    }

    // The heavier a query, the more it takes; where it takes the last of a seed nothing jumps.
    TEST_CASE("shares: a field is continuous where a query buries a seed") {
        votess::Options options;
        options.box = test::unit_box();
        const Coordinates points{0.2, 0.2, 0.2, 0.8, 0.25, 0.3, 0.3, 0.8, 0.7, 0.7, 0.75, 0.2, 0.5, 0.45, 0.55};
        const std::vector<double> light{0.1, 0.1, 0.1, 0.1, 0.08}, query{0.45, 0.5, 0.5}, values{1, 2, 3, 4, 50};
        options.weights = light;
        const votess::Diagram diagram(points, options);
        const auto seeds_at = [&](double weight, votess::NaturalMethod method) {
            votess::NaturalOptions at;
            at.method = method;
            at.weights = std::span(&weight, 1);
            return row_of(diagram.natural_neighbors(query, at), 0).seeds;
        };
        const auto field_at = [&](double weight) {
            votess::NaturalOptions at;
            at.weights = std::span(&weight, 1);
            return diagram.interpolate(values, 1, query, at).values[0];
        };
        const auto has_face = [&](double weight) {
            return std::ranges::count(seeds_at(weight, votess::NaturalMethod::laplace), 4) == 1;
        };
        double before = 0.08, after = 0.6;
        REQUIRE(has_face(before));
        REQUIRE(!has_face(after));
        while (after - before > 1e-12) (has_face(0.5 * (before + after)) ? before : after) = 0.5 * (before + after);
        CHECK(std::ranges::count(seeds_at(after, votess::NaturalMethod::sibson), 4) == 1);
        CHECK(field_at(before) == doctest::Approx(field_at(after)).epsilon(1e-9));
        CHECK(field_at(before) == doctest::Approx(field_at(before - 1e-6)).epsilon(1e-3));
        CHECK(field_at(after) == doctest::Approx(field_at(after + 1e-6)).epsilon(1e-3));
    }
}

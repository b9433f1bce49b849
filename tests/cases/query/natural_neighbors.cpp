// Diagram::natural_neighbors() and interpolate(), against rational arithmetic where topology is hard: ties, walls,
// buried seeds, close pairs.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <string>
#include <vector>
#include <votess/diagram.hpp>

#include "cases/query/query_cases.hpp"
#include "oracle/shares.hpp"
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
    // Seeds outside have a part of the domain, too.
    if (random.below(3) == 0) {
        c.options.outside = votess::Outside::keep;
        for (double& x : c.points) x = 0.5 + 1.75 * (x - 0.5);
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

struct NaturalRow {
    std::vector<std::int32_t> seeds;
    std::vector<double> weights, gradients;
};
NaturalRow row_of(const votess::NaturalCoordinates& c, std::size_t q) {
    const auto begin = c.indptr[q], end = c.indptr[q + 1];
    NaturalRow row;
    row.seeds.assign(c.indices.begin() + begin, c.indices.begin() + end);
    row.weights.assign(c.weights.begin() + begin, c.weights.begin() + end);
    if (!c.gradients.empty()) row.gradients.assign(c.gradients.begin() + 3 * begin, c.gradients.begin() + 3 * end);
    return row;
}

// Returns what is wrong with a row; expected: by seed, those that are positive.
std::string check_weights(const NaturalRow& row, const std::map<std::int32_t, double>& expected) {
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

std::string check_sibson(const NaturalRow& row, const test::Shares& exact) {
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

std::string check_laplace(const NaturalRow& row, const test::Shares& exact) {
    std::map<std::int32_t, double> expected;
    double sum = 0;
    for (const auto& [seed, share] : exact.of) sum += share.area;
    for (const auto& [seed, share] : exact.of)
        if (share.area > 0) expected[seed] = share.area / sum;
    return check_weights(row, expected);
}

struct Set {
    const char* name;
    Coordinates points;
    std::vector<double> weights;
    votess::Options options;
};

std::vector<Set> sets(std::size_t n) {
    std::vector<Set> all;
    const auto add = [&](const char* name, Coordinates points) -> votess::Options& {
        all.push_back({name, std::move(points), {}, {}});
        all.back().options.box = test::unit_box();
        return all.back().options;
    };
    add("box", test::uniform(n, 1).points);
    add("clusters", test::clustered(n, 2).points);
    add("periodic", test::uniform(n, 3).points).periodic = {true, true, true};
    add("partly periodic", test::uniform(n, 4).points).periodic = {true, false, true};
    Coordinates some, wedge = test::uniform(3 * n, 5).points;
    for (std::size_t i = 0; i < wedge.size(); i += 3)
        if (wedge[i] + wedge[i + 1] + 0.5 * wedge[i + 2] < 1.6 && -wedge[i] + 2 * wedge[i + 1] < 1.2)
            some.insert(some.end(), &wedge[i], &wedge[i] + 3);
    add("walls", some).walls = {{{1, 1, 0.5}, 1.6}, {{-1, 2, 0}, 1.2}};
    votess::Options& tilted = add("triclinic", test::uniform(n, 6).points);
    tilted.box.reset();
    tilted.cell = votess::TriclinicBox{{}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.2, 1}};
    test::Random random(7);
    for (const char* name : {"power", "periodic power"}) {
        add(name, test::uniform(n, 8).points).periodic.fill(name[1] == 'e');
        for (std::size_t i = 0; i < n; ++i) all.back().weights.push_back(random.uniform(0, 0.01));
    }
    // Vertices of eight cells: the division by edges gives up.
    Coordinates lattice;
    for (int i = 0; i < 216; ++i)
        for (const int c : {i % 6, i / 6 % 6, i / 36}) lattice.push_back((c + 0.5) / 6);
    add("lattice", lattice);
    add("periodic lattice", lattice).periodic = {true, true, true};
    for (Set& set : all) set.options.weights = set.weights;
    return all;
}

votess::Options with_weights(const Set& set) {
    votess::Options options = set.options;
    options.weights = set.weights;
    return options;
}

Coordinates queries_in(std::size_t count, double margin, std::uint64_t seed) {
    test::Random random(seed);
    Coordinates x;
    for (std::size_t i = 0; i < 3 * count; ++i) x.push_back(random.uniform(margin, 1 - margin));
    return x;
}

}  // namespace

TEST_SUITE("query") {
    TEST_CASE("natural neighbors: queries against rational arithmetic") {
        Random random(20);
        const std::size_t wanted = test::by_size(140, 30);
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
                NaturalRow row, areas;
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
        CHECK(at_walls > wanted / 5);
        CHECK(periodic > wanted / 20);
    }

    TEST_CASE("natural neighbors: the bisector of two seeds meets an edge of the domain") {
        votess::Options options;
        options.box = test::unit_box();
        const votess::Diagram diagram(Coordinates{0, 0, 0, 0, 1, 0, 1, 1, 0}, options);
        const NaturalRow row = row_of(diagram.natural_neighbors(Coordinates{0.6141, 0.1592, 0.8754}), 0);
        REQUIRE(row.seeds.size() == 3);
        CHECK(row.weights[0] == doctest::Approx(0.451563).epsilon(1e-5));
        CHECK(row.weights[1] == doctest::Approx(0.167306).epsilon(1e-5));
        CHECK(row.weights[2] == doctest::Approx(0.381131).epsilon(1e-5));
    }

    TEST_CASE("natural neighbors: seeds outside against rational arithmetic") {
        Random random(24);
        std::size_t checked = 0, buried = 0;
        const std::size_t sets = test::by_size(90, 30);
        for (std::size_t set = 0; set < sets; ++set) {
            CAPTURE(set);
            QueryCase c;
            c.options.box = test::unit_box();
            c.options.outside = votess::Outside::keep;
            const auto domain = random.below(4);
            if (domain == 1) c.options.periodic[2] = true;
            if (domain == 2) {
                c.options.box.reset();
                c.options.cell =
                    votess::TriclinicBox{{}, {1, 0, 0}, {0.25, 1, 0}, {-0.25, 0.25, 1}, {true, false, true}};
            }
            if (domain == 3) c.options.walls = {{{1, 1, 0}, 1.5}};
            for (auto inside = 1 + random.below(3); inside > 0; --inside)
                for (int k = 0; k < 3; ++k) c.points.push_back(rounded(random.uniform(0.2, 0.8)));
            for (auto outside = 1 + random.below(3); outside > 0; --outside) {
                const auto axis = domain == 2 ? 1 : random.below(2);
                for (std::uint64_t k = 0; k < 3; ++k) {
                    const double x = random.uniform(0, 1);
                    c.points.push_back(rounded(k != axis ? x : x < 0.5 ? -x : 0.5 + x));
                }
            }
            if (random.below(3) == 0)
                for (std::size_t i = 0; 3 * i < c.points.size(); ++i) c.weights.push_back(random.uniform(0, 0.1));
            c = without_duplicates(c);
            votess::Options options = c.options;
            options.weights = c.weights;
            const votess::Diagram diagram(c.points, options);
            for (int q = 0; q < 4; ++q) {
                CAPTURE(q);
                const std::array<double, 3> x{rounded(random.uniform()), rounded(random.uniform()),
                                              rounded(random.uniform())};
                if (diagram.locate(x)[0] < 0) continue;
                const auto exact = test::exact_shares(c.points, c.weights, c.options, x, 0);
                NaturalRow row;
                votess::NaturalOptions sibson;
                sibson.gradients = true;
                const auto code = test::error_of([&] { row = row_of(diagram.natural_neighbors(x, sibson), 0); });
                CHECK((code == votess::ErrorCode::unsupported) == exact.meets_itself);
                if (code || exact.volume == 0 || (!row.gradients.empty() && std::isnan(row.gradients[0]))) continue;
                CHECK(check_sibson(row, exact) == "");
                ++checked;
                buried += std::ranges::any_of(
                    exact.of, [](const auto& of) { return of.second.volume > 0 && of.second.area == 0; });
            }
        }
        CHECK(checked > sets);
        CHECK(buried > sets / 20);
    }

    // The volumes of all cells, without and with the query, know nothing of parts.
    TEST_CASE("natural neighbors: a query with a thousand neighbors") {
        Random random(25);
        Coordinates sphere, sheet;
        while (sphere.size() < 3 * test::by_size(1000, 300)) {
            const std::array<double, 3> x{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            const double length = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
            if (length > 0.1 && length < 1)
                for (const double c : x) sphere.push_back(0.5 + 0.4 * c / length);
        }
        for (int i = 0; i < 1024; ++i) {
            sheet.push_back((i % 32 + random.uniform(0.2, 0.8)) / 32);
            sheet.push_back((i / 32 + random.uniform(0.2, 0.8)) / 32);
            sheet.push_back(0.5 + 1e-3 * random.uniform());
        }
        votess::Options options;
        options.box = test::unit_box();
        options.device = "cpu";
        for (const int kind : {0, 1, 2, 3, 4, 5, 6, 7}) {
            CAPTURE(kind);
            const bool flat = kind % 2 == 1;
            const Coordinates &points = flat ? sheet : sphere, query{0.5, 0.5, flat ? 0.9 : 0.5};
            options.periodic = {kind >= 4, kind >= 4, kind >= 4};
            std::vector<double> weights;
            for (std::size_t i = 0; i < points.size() / 3 && kind / 2 % 2 == 1; ++i)
                weights.push_back(random.uniform(0, 1e-3));
            options.weights = weights;
            votess::NaturalOptions sibson;
            const std::vector<double> of_query(weights.empty() ? 0 : 1, 1e-3);
            sibson.weights = of_query;
            const NaturalRow row = row_of(votess::Diagram(points, options).natural_neighbors(query, sibson), 0);
            Coordinates all = points;
            all.insert(all.end(), query.begin(), query.end());
            const auto before = votess::tessellate(points, options);
            weights.insert(weights.end(), of_query.begin(), of_query.end());
            options.weights = weights;
            const auto after = votess::tessellate(all, options);
            std::vector<double> shares(before.size());
            for (std::size_t i = 0; i < shares.size(); ++i)
                shares[i] = (before.volumes()[i] - after.volumes()[i]) / after.volumes().back();
            for (std::size_t e = 0; e < row.seeds.size(); ++e) {
                double& share = shares[static_cast<std::size_t>(row.seeds[e])];
                CHECK(std::abs(row.weights[e] - share) < max_error);
                share = 0;
            }
            CHECK(std::ranges::all_of(shares, [](double share) { return std::abs(share) < max_error; }));
            CHECK(row.seeds.size() > (kind / 2 % 2 == 1 ? test::by_size(100, 30) : test::by_size(500, 150)));
        }
    }

    // The graph of all vertices answers many queries at once.
    TEST_CASE("natural neighbors: many queries among many seeds") {
        Random random(21);
        for (const int kind : {0, 1, 2, 3}) {
            CAPTURE(kind);
            const bool weighted = kind % 2 == 1, outside = kind >= 2;
            QueryCase c;
            c.points = test::uniform(64, weighted ? 22 : 23).points;
            if (outside) {
                c.options.outside = votess::Outside::keep;
                c.options.walls = {{{1, 1, 0.5}, 2}};
                for (double& x : c.points) x = 0.5 + 1.25 * (x - 0.5);
            }
            for (double& x : c.points) x = rounded(x);
            for (int i = 0; i < 64 && weighted; ++i) c.weights.push_back(rounded(random.uniform(0, 0.02)));
            c.options.box = test::unit_box();
            votess::Options options = c.options;
            options.weights = c.weights;
            const votess::Diagram diagram(c.points, options);
            const std::size_t count = 32;
            Coordinates queries;
            for (std::size_t i = 0; i < 3 * count; ++i) queries.push_back(rounded(random.uniform()));
            std::vector<double> weights;
            for (std::size_t i = 0; i < count && weighted; ++i) weights.push_back(rounded(random.uniform(0, 0.05)));
            votess::NaturalOptions sibson;
            sibson.gradients = true;
            sibson.weights = weights;
            const auto found = diagram.natural_neighbors(queries, sibson);
            const std::vector<std::int32_t> owners = diagram.locate(queries);
            for (std::size_t q = 0; q < count; ++q) {
                CAPTURE(q);
                if (owners[q] < 0) {
                    CHECK(row_of(found, q).seeds.empty());
                    continue;
                }
                const auto exact = test::exact_shares(c.points, c.weights, c.options,
                                                      {queries[3 * q], queries[3 * q + 1], queries[3 * q + 2]},
                                                      weighted ? weights[q] : 0);
                CHECK(check_sibson(row_of(found, q), exact) == "");
            }
        }
    }

    // The heavier a query, the more it takes; where it takes the last of a seed nothing jumps.
    TEST_CASE("natural neighbors: a field is continuous where a query buries a seed") {
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

    TEST_CASE("natural neighbors: weights sum to 1, and linear fields come back off the walls") {
        for (const Set& set : sets(test::by_size(1000, 300))) {
            CAPTURE(set.name);
            const votess::Diagram diagram(set.points, with_weights(set));
            const std::size_t n = set.points.size() / 3;
            std::vector<double> linear(n);
            for (std::size_t i = 0; i < n; ++i)
                linear[i] = 1 + 2 * set.points[3 * i] - set.points[3 * i + 1] + 0.5 * set.points[3 * i + 2];
            // So many that the graph of all vertices is made, but not for the first few.
            const Coordinates queries = queries_in(test::by_size(600, 200), 0, 10);
            const auto few = diagram.natural_neighbors(std::span(queries).first(3 * 40));
            for (const auto method : {votess::NaturalMethod::sibson, votess::NaturalMethod::laplace}) {
                votess::NaturalOptions options;
                options.method = method;
                const auto all = diagram.natural_neighbors(queries, options);
                if (method == votess::NaturalMethod::sibson) {
                    const auto size = static_cast<std::size_t>(few.indptr.back());
                    CHECK(std::ranges::equal(few.indices, std::span(all.indices).first(size)));
                    for (std::size_t e = 0; e < size; ++e) CHECK(std::abs(few.weights[e] - all.weights[e]) < 1e-11);
                }
                options.at_walls = false;
                options.gradients = method == votess::NaturalMethod::sibson;
                const auto inside = diagram.natural_neighbors(queries, options);
                const auto values = diagram.interpolate(linear, 1, queries, options);
                const bool repeats = set.options.periodic[0] || set.options.cell;
                std::size_t inner = 0;
                for (std::size_t q = 0; q < queries.size() / 3; ++q) {
                    const auto row = [q](const auto& c) {
                        return std::span(c.weights).subspan(static_cast<std::size_t>(c.indptr[q]),
                                                            static_cast<std::size_t>(c.indptr[q + 1] - c.indptr[q]));
                    };
                    const auto weights = row(all);
                    if (!weights.empty())
                        CHECK(std::abs(std::accumulate(weights.begin(), weights.end(), 0.0) - 1) < 1e-13);
                    CHECK(std::ranges::all_of(weights, [](double w) { return w >= 0; }));
                    if (row(inside).empty()) {
                        CHECK(std::isnan(values.values[q]));
                        continue;
                    }
                    // Gradients may ask for more digits.
                    CHECK(std::ranges::equal(row(inside), weights,
                                             [](double a, double b) { return std::abs(a - b) < 1e-13; }));
                    ++inner;
                    if (repeats) continue;  // images have other coordinates
                    const double* x = &queries[3 * q];
                    const double expected = 1 + 2 * x[0] - x[1] + 0.5 * x[2];
                    CHECK(values.values[q] == doctest::Approx(expected).epsilon(1e-12));
                    if (values.gradients.empty()) continue;
                    const double slope[3] = {2, -1, 0.5};
                    for (std::size_t k = 0; k < 3; ++k)
                        CHECK(values.gradients[3 * q + k] == doctest::Approx(slope[k]).epsilon(1e-7));
                }
                CHECK(inner > queries.size() / 3 / 20);
            }
        }
    }

    TEST_CASE("natural neighbors: queries on seeds, outside, and what is refused") {
        votess::Options options;
        options.box = test::unit_box();
        const auto set = test::uniform(50, 13);
        const votess::Diagram diagram(set.points, options);
        Coordinates queries(&set.points[3 * 7], &set.points[3 * 7] + 3);
        queries.insert(queries.end(), {2, 0.5, 0.5});
        const auto found = diagram.natural_neighbors(queries);
        CHECK(found.indptr == std::vector<std::int64_t>{0, 1, 1});
        CHECK(found.indices == std::vector<std::int32_t>{7});
        CHECK(found.weights == std::vector<double>{1});
        std::vector<double> values(50);
        std::iota(values.begin(), values.end(), 0.0);
        const auto at = diagram.interpolate(values, 1, queries);
        CHECK(at.values[0] == 7);
        CHECK(std::isnan(at.values[1]));
        CHECK(at.gradients.empty());
        CHECK(votess::Diagram().natural_neighbors(queries).indices.empty());

        const auto code = [](const auto& call) { return test::error_of(call); };
        votess::NaturalOptions laplace;
        laplace.method = votess::NaturalMethod::laplace;
        laplace.gradients = true;
        const auto invalid = votess::ErrorCode::invalid_argument;
        CHECK(code([&] { (void)diagram.natural_neighbors(queries, laplace); }) == invalid);
        CHECK(code([&] { (void)diagram.interpolate(values, 3, queries); }) == invalid);
        CHECK(code([&] { (void)diagram.interpolate(values, 0, queries); }) == invalid);
        votess::NaturalOptions weighted;
        const std::vector<double> weights{0, 0};
        weighted.weights = weights;
        CHECK(code([&] { (void)diagram.natural_neighbors(queries, weighted); }) == invalid);
        // One seed in a periodic box: the cell of a query meets its own image.
        options.periodic = {true, true, true};
        const votess::Diagram lonely(Coordinates{0.5, 0.5, 0.5}, options);
        CHECK(code([&] {
                  (void)lonely.natural_neighbors(Coordinates{0.1, 0.2, 0.3});
              }) == votess::ErrorCode::unsupported);
    }
}

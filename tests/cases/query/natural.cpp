// Natural-neighbor coordinates against what they are by definition: the volumes that cells lose to the query.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>
#include <votess/diagram.hpp>

#include "cases/query/query_cases.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;

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

double weight_of(const votess::NaturalCoordinates& c, std::size_t q, std::int32_t seed) {
    for (auto e = c.indptr[q]; e < c.indptr[q + 1]; ++e)
        if (c.indices[static_cast<std::size_t>(e)] == seed) return c.weights[static_cast<std::size_t>(e)];
    return 0;
}

}  // namespace

TEST_SUITE("natural") {
    TEST_CASE("natural: Sibson's weights are the volumes that cells lose") {
        for (const Set& set : sets(test::by_size(150, 60))) {
            CAPTURE(set.name);
            votess::Options options = with_weights(set);
            const votess::Diagram diagram(set.points, options);
            const std::size_t n = set.points.size() / 3;
            const auto before = votess::tessellate(set.points, options);
            const Coordinates queries = queries_in(12, 0.05, 9);
            const auto found = diagram.natural_neighbors(queries);
            for (std::size_t q = 0; q < queries.size() / 3; ++q) {
                CAPTURE(q);
                Coordinates with = set.points;
                with.insert(with.end(), &queries[3 * q], &queries[3 * q] + 3);
                std::vector<double> weights = set.weights;
                if (!weights.empty()) weights.push_back(0);
                options.weights = weights;
                options.outside = votess::Outside::drop;
                const auto after = votess::tessellate(with, options);
                const double volume = after.volumes()[n];
                CHECK((found.indptr[q + 1] > found.indptr[q]) == (volume > 0));
                if (!(volume > 0)) continue;
                double worst = 0;
                for (std::size_t i = 0; i < n; ++i) {
                    const double lost = (before.volumes()[i] - after.volumes()[i]) / volume;
                    worst = std::max(worst, std::abs(lost - weight_of(found, q, static_cast<std::int32_t>(i))));
                }
                CHECK(worst < 1e-9 / std::min(1.0, volume * static_cast<double>(n)));
            }
        }
    }

    TEST_CASE("natural: weights sum to 1, and linear fields come back off the walls") {
        for (const Set& set : sets(test::by_size(2000, 300))) {
            CAPTURE(set.name);
            const votess::Diagram diagram(set.points, with_weights(set));
            const std::size_t n = set.points.size() / 3;
            std::vector<double> linear(n);
            for (std::size_t i = 0; i < n; ++i)
                linear[i] = 1 + 2 * set.points[3 * i] - set.points[3 * i + 1] + 0.5 * set.points[3 * i + 2];
            // So many that the graph of all vertices is made, but not for the first few.
            const Coordinates queries = queries_in(test::by_size(1200, 200), 0, 10);
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

    TEST_CASE("natural: gradients are those of the interpolated field") {
        constexpr double h = 1e-5;
        for (const Set& set : sets(test::by_size(300, 100))) {
            CAPTURE(set.name);
            const votess::Diagram diagram(set.points, with_weights(set));
            test::Random random(11);
            std::vector<double> values(set.points.size() / 3 * 2);
            for (double& value : values) value = random.uniform();
            const Coordinates queries = queries_in(20, 0.05, 12);
            votess::NaturalOptions options;
            options.gradients = true;
            const auto found = diagram.interpolate(values, 2, queries, options);
            for (std::size_t q = 0; q < queries.size() / 3; ++q)
                for (std::size_t k = 0; k < 3; ++k) {
                    Coordinates ends;
                    for (const double by : {-h, h}) {
                        ends.insert(ends.end(), &queries[3 * q], &queries[3 * q] + 3);
                        ends[ends.size() - 3 + k] += by;
                    }
                    const auto at = diagram.interpolate(values, 2, ends).values;
                    for (std::size_t c = 0; c < 2; ++c) {
                        const double slope = (at[2 + c] - at[c]) / (2 * h), own = found.gradients[6 * q + 3 * c + k];
                        if (std::isnan(slope)) continue;
                        CHECK(own == doctest::Approx(slope).epsilon(1e-3).scale(10));
                    }
                }
        }
    }

    TEST_CASE("natural: queries on seeds, outside, and what is refused") {
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

        const auto code = [](const auto& ask) {
            try {
                ask();
            } catch (const votess::Error& error) {
                return error.code();
            }
            return votess::ErrorCode{};
        };
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

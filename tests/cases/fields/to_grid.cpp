// to_grid(): threads, the nearest seed, and what is refused.
#include <doctest/doctest.h>

#include <cmath>

#include "cases/fields/field_cases.hpp"
#include "support/check.hpp"

namespace {

using test::FieldCase;
using votess::GridMethod;
using votess::GridOptions;

// The message of the refusal.
std::string refusal(const votess::Diagram& diagram, const std::vector<double>& values, const GridOptions& options,
                    std::size_t size) {
    std::vector<double> grid(size);
    try {
        diagram.to_grid(values, options, grid);
    } catch (const votess::Error& error) {
        CHECK(error.code() == votess::ErrorCode::invalid_argument);
        return error.what();
    }
    return "";
}

// In the order of the grid.
test::Coordinates centers_of(const votess::Options& options, const std::array<std::size_t, 3>& shape) {
    test::Coordinates centers;
    const auto [nx, ny, nz] = shape;
    for (std::size_t cell = 0; cell < nx * ny * nz; ++cell) {
        const std::array<std::size_t, 3> at{cell / (ny * nz), cell / nz % ny, cell % nz};
        test::Coordinates f;
        for (std::size_t k = 0; k < 3; ++k)
            f.push_back((static_cast<double>(at[k]) + 0.5) / static_cast<double>(shape[k]));
        if (options.cell)
            f = test::inside(*options.cell, f);
        else
            for (std::size_t k = 0; k < 3; ++k)
                f[k] = options.box->lower[k] + f[k] * (options.box->upper[k] - options.box->lower[k]);
        centers.insert(centers.end(), f.begin(), f.end());
    }
    return centers;
}

}  // namespace

TEST_SUITE("to_grid") {
    TEST_CASE("to_grid: the same digits with any number of threads") {
        for (FieldCase& c : test::field_cases(test::by_size(300, 60))) {
            CAPTURE(c.name);
            const std::vector<double> values = test::some_weights(c.points.size() / 3, 1);
            for (const auto method : {GridMethod::mean, GridMethod::dtfe, GridMethod::nearest}) {
                const GridOptions options{.shape = {9, 20, 3}, .method = method};
                c.options.threads = 1;
                const auto one = test::grid_of(votess::Diagram(c.points, c.options), values, options);
                for (const unsigned threads : {2u, 5u, 0u}) {
                    if (test::reduced() && threads != 5) continue;
                    c.options.threads = threads;
                    REQUIRE(test::grid_of(votess::Diagram(c.points, c.options), values, options) == one);
                }
            }
        }
    }

    TEST_CASE("to_grid: nearest has the value of the seed whose cell holds the center") {
        for (FieldCase& c : test::field_cases(100)) {
            CAPTURE(c.name);
            const std::size_t n = c.points.size() / 3;
            const auto weights = test::some_weights(n, 0.02);
            c.options.weights = weights;
            const votess::Diagram diagram(c.points, c.options);
            const std::vector<double> values = test::some_weights(2 * n, 1);
            GridOptions options{.shape = {3, 4, 5}, .method = GridMethod::nearest, .columns = 2};
            const auto grid = test::grid_of(diagram, values, options);
            std::vector<double> sums(2 * 3 * 5, 0);
            const auto seeds = diagram.locate(centers_of(c.options, options.shape));
            for (std::size_t cell = 0; cell < 60; ++cell)
                for (std::size_t m = 0; m < 2; ++m) {
                    const double value = seeds[cell] < 0 ? 0 : values[2 * static_cast<std::size_t>(seeds[cell]) + m];
                    // Where cells meet, rounding of the center decides.
                    if (c.name != "lattice") REQUIRE(grid[2 * cell + m] == value);
                    sums[2 * (cell / 20 * 5 + cell % 5) + m] += grid[2 * cell + m];
                }
            options.project = 1;
            const auto projected = test::grid_of(diagram, values, options);
            const double length = c.options.cell
                                      ? std::hypot(c.options.cell->b[0], c.options.cell->b[1], c.options.cell->b[2])
                                      : c.options.box->upper[1] - c.options.box->lower[1];
            for (std::size_t i = 0; i < sums.size(); ++i)
                REQUIRE(projected[i] == doctest::Approx(sums[i] * length / 4).epsilon(1e-13));
        }
    }

    TEST_CASE("to_grid: sibson has the value interpolated at the center, 0 outside and NaN without coordinates") {
        std::size_t outside = 0, hidden = 0;
        for (FieldCase& c : test::field_cases(test::by_size(300, 100)))
            for (const double weight : {0.0, 0.3}) {
                if (c.name == "two seeds, periodic") continue;
                CAPTURE(c.name);
                CAPTURE(weight);
                const std::size_t n = c.points.size() / 3;
                // Large ones bury queries, whose weight is 0.
                const auto weights = test::some_weights(n, weight);
                c.options.weights = weight > 0 ? std::span<const double>(weights) : std::span<const double>();
                const votess::Diagram diagram(c.points, c.options);
                const std::vector<double> values = test::some_weights(2 * n, 1);
                const GridOptions options{.shape = {7, 4, 9}, .method = GridMethod::sibson, .columns = 2};
                const auto grid = test::grid_of(diagram, values, options);
                const auto centers = centers_of(c.options, options.shape);
                const auto seeds = diagram.locate(centers);
                const auto expected = diagram.interpolate(values, 2, centers).values;
                for (std::size_t i = 0; i < grid.size(); ++i) {
                    outside += seeds[i / 2] < 0;
                    hidden += seeds[i / 2] >= 0 && std::isnan(expected[i]);
                    if (c.name == "lattice") continue;  // its rim depends on how centers are rounded
                    if (seeds[i / 2] < 0)
                        REQUIRE(grid[i] == 0);
                    else if (std::isnan(expected[i]))
                        REQUIRE(std::isnan(grid[i]));
                    else
                        REQUIRE(std::abs(grid[i] - expected[i]) <= 1e-9);
                }
            }
        CHECK(outside > 0);
        CHECK(hidden > 0);
    }

    TEST_CASE("to_grid: cells over many decades keep their sums") {
        for (const auto& set : {test::nested_clusters(test::by_size(2000, 300), 3), test::on_walls(200, 4),
                                test::near_duplicates(200, 5), test::scaled(test::uniform(200, 6), 1e-90)}) {
            CAPTURE(set.name);
            votess::Options tessellate = test::all_options(set.box);
            tessellate.want.faces = true;
            const auto t = votess::tessellate(set.points, tessellate);
            std::vector<double> densities(set.size(), 0);
            double mass = 0;
            for (std::size_t i = 0; i < set.size(); ++i) {
                if (!(t.volumes()[i] > 0)) continue;
                densities[i] = 1 / t.volumes()[i];
                mass += 1;
            }
            const GridOptions options{.shape = {7, 8, 9}};
            const votess::Diagram diagram(set.points, test::all_options(set.box));
            double sum = 0;
            for (const double x : test::grid_of(diagram, densities, options))
                sum += x * test::grid_cell_volume(t, options);
            CHECK(std::abs(sum - mass) <= 1e-12 * mass);
        }
    }

    TEST_CASE("to_grid: no seeds, no field") {
        votess::Options options;
        options.box = test::unit_box();
        const votess::Diagram nothing({}, options);
        options.outside = votess::Outside::drop;
        const votess::Diagram dropped(std::vector<double>{2, 2, 2, 3, 3, 3}, options);
        for (const auto method : {GridMethod::mean, GridMethod::dtfe, GridMethod::nearest, GridMethod::sibson}) {
            const GridOptions grid{.shape = {2, 1, 1}, .method = method};
            CHECK(test::grid_of(nothing, {}, grid) == std::vector<double>{0, 0});
            CHECK(test::grid_of(dropped, {1, 1}, grid) == std::vector<double>{0, 0});
        }
    }

    TEST_CASE("to_grid: refused") {
        const auto set = test::uniform(20, 1);
        const votess::Diagram diagram(set.points);
        const std::vector<double> values(20, 1);
        GridOptions grid{.shape = {2, 3, 4}};
        CHECK(refusal(diagram, values, grid, 24) == "");
        CHECK(refusal(diagram, values, grid, 23) ==
              "to_grid(): the grid holds 23 numbers, its shape needs 24 for each of 1 columns");
        CHECK(refusal(diagram, {1, 2}, grid, 24) == "to_grid(): there are 2 values, 20 seeds need 1 each");
        grid.method = GridMethod::nearest;
        grid.shape[1] = 0;
        CHECK(refusal(diagram, values, grid, 0) == "to_grid(): shape[1] = 0 is not from 1 to 1048576");
        grid.shape[1] = std::size_t{1} << 40;
        CHECK(refusal(diagram, values, grid, 0).starts_with("to_grid(): shape[1] = 1099511627776 is not"));
        grid.shape[1] = 1;
        grid.project = 3;
        CHECK(refusal(diagram, values, grid, 8) == "to_grid(): project = 3 is not an axis: give 0, 1 or 2");
        grid.project = {};
        grid.columns = 0;
        CHECK(refusal(diagram, values, grid, 0) == "to_grid(): columns = 0 is not from 1 to 1048576");
        grid.columns = 1;
        grid.method = static_cast<GridMethod>(7);
        CHECK(refusal(diagram, values, grid, 8) ==
              "to_grid(): method = 7 is none: it is 0 mean, 1 dtfe, 2 nearest or 3 sibson");
    }
}

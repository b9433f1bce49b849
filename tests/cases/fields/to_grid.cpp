// to_grid(): threads, the nearest seed, and what is refused.
#include <doctest/doctest.h>

#include <votess/diagram.hpp>

#include "cases/fields/field_cases.hpp"
#include "support/check.hpp"

namespace {

using test::FieldCase;
using votess::GridMethod;
using votess::GridOptions;

// The message of the refusal.
std::string refusal(const votess::Tessellation& t, const test::Coordinates& points, const std::vector<double>& values,
                    const GridOptions& options, std::size_t size) {
    std::vector<double> grid(size);
    try {
        votess::to_grid(t, points, values, options, grid);
    } catch (const votess::Error& error) {
        CHECK(error.code() == votess::ErrorCode::invalid_argument);
        return error.what();
    }
    return "";
}

}  // namespace

TEST_SUITE("to_grid") {
    TEST_CASE("to_grid: the same digits with any number of threads") {
        for (const FieldCase& c : test::field_cases(test::by_size(300, 60))) {
            CAPTURE(c.name);
            const auto t = votess::tessellate(c.points, c.options);
            const std::vector<double> values = test::some_weights(c.points.size() / 3, 1);
            for (const auto method : {GridMethod::mean, GridMethod::dtfe, GridMethod::nearest}) {
                GridOptions options{.shape = {9, 20, 3}, .method = method};
                options.threads = 1;
                const auto one = test::grid_of(t, c.points, values, options);
                for (const unsigned threads : {2u, 5u, 0u}) {
                    options.threads = threads;
                    REQUIRE(test::grid_of(t, c.points, values, options) == one);
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
            const auto t = votess::tessellate(c.points, c.options);
            const votess::Diagram diagram(c.points, c.options);
            const std::vector<double> values = test::some_weights(2 * n, 1);
            GridOptions options{.shape = {3, 4, 5}, .method = GridMethod::nearest, .columns = 2};
            const auto grid = test::grid_of(t, c.points, values, options);
            std::vector<double> sums(2 * 3 * 5, 0);
            for (std::size_t cell = 0; cell < 60; ++cell) {
                const test::Coordinates f{(static_cast<double>(cell / 20) + 0.5) / 3,
                                          (static_cast<double>(cell / 5 % 4) + 0.5) / 4,
                                          (static_cast<double>(cell % 5) + 0.5) / 5};
                test::Coordinates center;
                if (t.cell())
                    center = test::inside(*t.cell(), f);
                else
                    for (std::size_t k = 0; k < 3; ++k)
                        center.push_back(t.box().lower[k] + f[k] * (t.box().upper[k] - t.box().lower[k]));
                const auto seed = diagram.locate(center)[0];
                for (std::size_t m = 0; m < 2; ++m) {
                    const double value = seed < 0 ? 0 : values[2 * static_cast<std::size_t>(seed) + m];
                    // Where cells meet, rounding of the center decides.
                    if (c.name != "lattice") REQUIRE(grid[2 * cell + m] == value);
                    sums[2 * (cell / 20 * 5 + cell % 5) + m] += grid[2 * cell + m];
                }
            }
            options.project = 1;
            const auto projected = test::grid_of(t, c.points, values, options);
            const double length = t.cell() ? std::hypot(t.cell()->b[0], t.cell()->b[1], t.cell()->b[2])
                                           : t.box().upper[1] - t.box().lower[1];
            for (std::size_t i = 0; i < sums.size(); ++i)
                REQUIRE(projected[i] == doctest::Approx(sums[i] * length / 4).epsilon(1e-13));
        }
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
            double sum = 0;
            for (const double x : test::grid_of(t, set.points, densities, options))
                sum += x * test::grid_cell_volume(t, options);
            CHECK(std::abs(sum - mass) <= 1e-12 * mass);
        }
    }

    TEST_CASE("to_grid: no seeds, no field") {
        votess::Options options;
        options.box = test::unit_box();
        options.want.faces = true;
        for (const auto method : {GridMethod::mean, GridMethod::dtfe, GridMethod::nearest})
            CHECK(test::grid_of(votess::tessellate(test::Coordinates{}, options), {}, {},
                                {.shape = {2, 1, 1}, .method = method}) == std::vector<double>{0, 0});
        // All of them outside.
        options.outside = votess::Outside::drop;
        const test::Coordinates points{2, 2, 2, 3, 3, 3};
        const auto t = votess::tessellate(points, options);
        for (const auto method : {GridMethod::mean, GridMethod::dtfe, GridMethod::nearest})
            CHECK(test::grid_of(t, points, {1, 1}, {.shape = {2, 1, 1}, .method = method}) ==
                  std::vector<double>{0, 0});
    }

    TEST_CASE("to_grid: refused") {
        const auto set = test::uniform(20, 1);
        votess::Options options = test::all_options(set.box);
        const auto bare = votess::tessellate(set.points, options);
        options.want.faces = true;
        const auto t = votess::tessellate(set.points, options);
        options.min_face = 0.1;
        const auto filtered = votess::tessellate(set.points, options);
        const std::vector<double> values(20, 1);
        GridOptions grid{.shape = {2, 3, 4}};
        CHECK(refusal(t, set.points, values, grid, 24) == "");
        CHECK(refusal(t, set.points, values, grid, 23) == "to_grid: the grid holds 23 numbers, its shape needs 24");
        CHECK(refusal(t, {1, 2, 3}, values, grid, 24) == "to_grid: points hold 3 coordinates, the result has 20 cells");
        CHECK(refusal(t, set.points, {1, 2}, grid, 24) == "to_grid: there are 2 values, 20 cells need 1 each");
        CHECK(refusal(bare, set.points, values, grid, 24) ==
              "to_grid: the tessellation has no polygons, set want.faces");
        CHECK(refusal(filtered, set.points, values, grid, 24) ==
              "to_grid: the tessellation has lost faces, set min_face and min_area to 0");
        votess::Want want;
        want.faces = true;
        CHECK(refusal(votess::Diagram(set.points).probe(set.points, {want, true, {}, {}}), set.points, values, grid, 24)
                  .starts_with("to_grid: these are cells of probes"));
        grid.method = GridMethod::nearest;
        CHECK(refusal(bare, set.points, values, grid, 24) == "");
        grid.shape[1] = 0;
        CHECK(refusal(t, set.points, values, grid, 0) == "to_grid: shape[1] = 0 is not from 1 to 1048576");
        grid.shape[1] = std::size_t{1} << 40;
        CHECK(refusal(t, set.points, values, grid, 0).starts_with("to_grid: shape[1] = 1099511627776 is not"));
        grid.shape[1] = 1;
        grid.project = 3;
        CHECK(refusal(t, set.points, values, grid, 8) == "to_grid: project = 3 is no axis: give 0, 1 or 2");
        grid.project = {};
        grid.columns = 0;
        CHECK(refusal(t, set.points, values, grid, 0) == "to_grid: columns = 0 is not from 1 to 1048576");
        grid.columns = 1;
        grid.threads = 2000;
        CHECK(refusal(t, set.points, values, grid, 8) ==
              "to_grid: threads = 2000 is too many: give at most 1024, or 0 for all");
        grid.threads = 1;
        grid.method = static_cast<GridMethod>(7);
        CHECK(refusal(t, set.points, values, grid, 8) ==
              "to_grid: method = 7 is none: it is 0 mean, 1 dtfe or 2 nearest");
    }
}

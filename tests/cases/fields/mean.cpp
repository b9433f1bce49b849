// to_grid(), mean: exact identities of averages, and what sampling finds.
#include <doctest/doctest.h>

#include "cases/fields/field_cases.hpp"
#include "support/check.hpp"

namespace {

using test::FieldCase;

// Every shape of small numbers, some of which divide the lattices.
const std::vector<std::array<std::size_t, 3>> shapes{{1, 1, 1}, {4, 4, 4}, {8, 2, 16}, {3, 5, 7}, {20, 1, 9}};

std::vector<double> random_values(std::size_t n, std::uint64_t seed) {
    test::Random random(seed);
    std::vector<double> values(n);
    for (double& v : values) v = random.uniform(-1, 1);
    return values;
}

// The grid times the volume of a grid cell has the sum of values times volumes.
void check_sum(const votess::Tessellation& t, const std::vector<double>& grid, const std::vector<double>& values,
               const votess::GridOptions& options) {
    double sum = 0, expected = 0, size = 0;
    for (const double x : grid) sum += x * test::grid_cell_volume(t, options);
    for (std::size_t i = 0; i < values.size(); ++i) {
        expected += values[i] * t.volumes()[i];
        size += std::abs(values[i]) * t.volumes()[i];
    }
    CHECK(std::abs(sum - expected) <= 1e-12 * size);
}

}  // namespace

TEST_SUITE("mean") {
    TEST_CASE("mean: ones are one everywhere, and sums are kept, in every domain") {
        for (FieldCase& c : test::field_cases(test::by_size(200, 30)))
            for (const double weight : {0.0, 0.02}) {
                const std::size_t n = c.points.size() / 3;
                const auto weights = test::some_weights(n, weight);
                c.options.weights = weight > 0 ? std::span<const double>(weights) : std::span<const double>();
                const auto t = votess::tessellate(c.points, c.options);
                const votess::Diagram diagram(c.points, c.options);
                // Large where cells are small, as densities are.
                std::vector<double> densities(n, 0);
                for (std::size_t i = 0; i < n; ++i)
                    if (t.volumes()[i] > 0) densities[i] = 1 / t.volumes()[i];
                for (const auto& shape : shapes) {
                    CAPTURE(c.name);
                    CAPTURE(weight);
                    CAPTURE(shape[0]);
                    votess::GridOptions options;
                    options.shape = shape;
                    const std::vector<double> ones(n, 1);
                    const auto covered = test::grid_of(diagram, ones, options);
                    check_sum(t, covered, ones, options);
                    if (c.options.walls.empty())
                        for (const double x : covered) REQUIRE(std::abs(x - 1) <= 1e-12);
                    else
                        for (const double x : covered) REQUIRE((x >= -1e-12 && x <= 1 + 1e-12));
                    check_sum(t, test::grid_of(diagram, densities, options), densities, options);
                    const auto values = random_values(n, 7);
                    check_sum(t, test::grid_of(diagram, values, options), values, options);
                }
            }
    }

    TEST_CASE("mean: a grid as fine as a lattice has its values") {
        const test::PointSet lattice = test::cubic(6, 0.1);
        votess::Options options;
        options.box = lattice.box;
        options.want.faces = true;
        for (const bool periodic : {false, true}) {
            options.periodic = {periodic, periodic, periodic};
            const votess::Diagram diagram(lattice.points, options);
            const auto values = random_values(lattice.size(), 3);
            const auto grid = test::grid_of(diagram, values, {.shape = {6, 6, 6}});
            for (std::size_t i = 0; i < values.size(); ++i) {
                std::size_t cell = 0;
                for (std::size_t k = 0; k < 3; ++k)
                    cell =
                        6 * cell + static_cast<std::size_t>((lattice.points[3 * i + k] - lattice.box->lower[k]) / 0.1);
                CHECK(std::abs(grid[cell] - values[i]) <= 1e-12);
            }
        }
    }

    TEST_CASE("mean: random places in each grid cell have that mean, as Diagram::locate sees them") {
        constexpr std::size_t samples = 4000;
        for (FieldCase& c : test::field_cases(40)) {
            if (c.name == "duplicates") continue;
            CAPTURE(c.name);
            const std::size_t n = c.points.size() / 3;
            const auto weights = test::some_weights(n, 0.01);
            c.options.weights = weights;
            const auto t = votess::tessellate(c.points, c.options);
            const votess::Diagram diagram(c.points, c.options);
            const auto values = random_values(n, 9);
            const std::array<std::size_t, 3> shape{3, 2, 2};
            const auto grid = test::grid_of(diagram, values, {.shape = shape});
            test::Random random(11);
            for (std::size_t cell = 0; cell < grid.size(); ++cell) {
                const std::array<std::size_t, 3> at{cell / 4, cell / 2 % 2, cell % 2};
                test::Coordinates queries;
                for (std::size_t s = 0; s < samples; ++s) {
                    std::array<double, 3> f{};
                    for (std::size_t k = 0; k < 3; ++k)
                        f[k] = (static_cast<double>(at[k]) + random.uniform()) / static_cast<double>(shape[k]);
                    if (t.cell()) {
                        const auto x = test::inside(*t.cell(), {f[0], f[1], f[2]});
                        queries.insert(queries.end(), x.begin(), x.end());
                    } else {
                        for (std::size_t k = 0; k < 3; ++k)
                            queries.push_back(t.box().lower[k] + f[k] * (t.box().upper[k] - t.box().lower[k]));
                    }
                }
                double sum = 0, squares = 0;
                for (const std::int32_t seed : diagram.locate(queries)) {
                    const double value = seed < 0 ? 0 : values[static_cast<std::size_t>(seed)];
                    sum += value;
                    squares += value * value;
                }
                const double mean = sum / samples, deviation = std::sqrt(squares / samples - mean * mean);
                // Five times what chance explains.
                CHECK(std::abs(grid[cell] - mean) <= 5 * deviation / std::sqrt(double{samples}) + 1e-12);
            }
        }
    }

    TEST_CASE("mean: columns are fields of their own, and projections integrate along an axis") {
        const FieldCase c = test::field_cases(200)[7];
        REQUIRE(c.options.cell.has_value());
        const votess::Diagram diagram(c.points, c.options);
        const std::size_t n = c.points.size() / 3;
        const auto one = random_values(n, 1), two = random_values(n, 2);
        std::vector<double> both;
        for (std::size_t i = 0; i < n; ++i) both.insert(both.end(), {one[i], two[i]});
        votess::GridOptions options{.shape = {4, 6, 5}};
        const auto of_one = test::grid_of(diagram, one, options), of_two = test::grid_of(diagram, two, options);
        options.columns = 2;
        const auto of_both = test::grid_of(diagram, both, options);
        for (std::size_t i = 0; i < of_one.size(); ++i) {
            REQUIRE(of_both[2 * i] == of_one[i]);
            REQUIRE(of_both[2 * i + 1] == of_two[i]);
        }
        options.columns = 1;
        const votess::TriclinicBox& cell = *c.options.cell;
        const std::array<std::array<double, 3>, 3> edges{cell.a, cell.b, cell.c};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            options.project = static_cast<int>(axis);
            const auto projected = test::grid_of(diagram, one, options);
            std::vector<double> sums(projected.size(), 0);
            const auto& e = edges[axis];
            const double step =
                std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) / static_cast<double>(options.shape[axis]);
            for (std::size_t x = 0, at = 0; x < 4; ++x)
                for (std::size_t y = 0; y < 6; ++y)
                    for (std::size_t z = 0; z < 5; ++z, ++at)
                        sums[axis == 0 ? y * 5 + z : axis == 1 ? x * 5 + z : x * 6 + y] += of_one[at] * step;
            for (std::size_t i = 0; i < sums.size(); ++i) REQUIRE(std::abs(sums[i] - projected[i]) <= 1e-12);
        }
    }

    TEST_CASE("mean: what is not a number stays where it is") {
        const test::PointSet lattice = test::cubic(4, 1);
        votess::Options options;
        options.box = lattice.box;
        options.want.faces = true;
        const votess::Diagram diagram(lattice.points, options);
        std::vector<double> values(lattice.size(), 1);
        values[0] = std::nan("");
        const auto grid = test::grid_of(diagram, values, {.shape = {2, 2, 2}});
        CHECK(std::isnan(grid[0]));
        for (std::size_t i = 1; i < 8; ++i) CHECK(std::abs(grid[i] - 1) < 1e-12);
    }
}

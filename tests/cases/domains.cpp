// Periodic boxes, triclinic cells, walls of any direction and weights, against exact half-spaces and Voro++.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>
#include <votess/votess.hpp>

#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using votess::Box;
using votess::Options;

Options domain_options() {
    Options options = test::all_options(test::unit_box());
    options.grid_resolution = 0;
    return options;
}

Coordinates random_points(test::Random& random, std::size_t n, double lower = 0, double upper = 1) {
    Coordinates points(3 * n);
    for (double& x : points) x = random.uniform(lower, upper);
    return points;
}

// Points on a coarse grid, each place once: full of ties.
Coordinates grid_points(test::Random& random, std::size_t n, int steps, double spacing) {
    Coordinates points;
    std::vector<std::array<int, 3>> taken;
    while (taken.size() < n) {
        const std::array<int, 3> at{static_cast<int>(random.below(static_cast<std::uint64_t>(steps))),
                                    static_cast<int>(random.below(static_cast<std::uint64_t>(steps))),
                                    static_cast<int>(random.below(static_cast<std::uint64_t>(steps)))};
        if (std::ranges::find(taken, at) != taken.end()) continue;
        taken.push_back(at);
        for (const int x : at) points.push_back(x * spacing);
    }
    return points;
}

std::string check(const Coordinates& points, const Options& options, int reach) {
    const auto t = votess::tessellate(std::span<const double>(points), options);
    if (auto failure = test::check_domain(t); !failure.empty()) return failure;
    return test::check_against_half_spaces(t, points, options, reach);
}

std::vector<std::size_t> face_counts(const votess::Tessellation& t) {
    std::vector<std::size_t> counts;
    for (std::size_t i = 0; i < t.size(); ++i) counts.push_back(t.neighbors(i).size());
    return counts;
}

Coordinates lattice(int length, std::initializer_list<std::array<double, 3>> motif) {
    Coordinates points;
    for (int i = 0; i < length; ++i)
        for (int j = 0; j < length; ++j)
            for (int k = 0; k < length; ++k)
                for (const auto& m : motif)
                    points.insert(points.end(), {(i + m[0]) / length, (j + m[1]) / length, (k + m[2]) / length});
    return points;
}

votess::TriclinicBox random_cell(test::Random& random) {
    votess::TriclinicBox cell;
    for (auto* v : {&cell.origin, &cell.a, &cell.b, &cell.c})
        for (double& x : *v) x = random.uniform(-0.4, 0.4);
    cell.a[0] += 1, cell.b[1] += 1, cell.c[2] += 1;
    return cell;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("domains: periodic axes of few seeds, against exact half-spaces") {
        test::Random random(1);
        const std::uint64_t rounds = test::by_size(2, 1);
        for (std::uint64_t round = 0; round < rounds; ++round)
            for (unsigned mask = 1; mask < 8; ++mask)
                for (const std::size_t n : {1, 2, 3, 6}) {
                    Options options = domain_options();
                    for (unsigned k = 0; k < 3; ++k) options.periodic[k] = ((mask >> k) & 1) != 0;
                    CAPTURE(mask);
                    CAPTURE(n);
                    CHECK(check(random_points(random, n), options, 2) == "");
                    CHECK(check(grid_points(random, n, 4, 0.25), options, 2) == "");
                }
    }

    TEST_CASE("domains: seeds far outside a periodic box are wrapped without rounding") {
        test::Random random(2);
        for (std::uint64_t round = 0; round < test::by_size(5, 2); ++round) {
            Options options = domain_options();
            options.periodic = {true, true, true};
            options.box = Box{{-0.1, 0.3, 1e-3}, {0.7, 1.1, 0.9}};  // lengths that are no doubles
            CHECK(check(random_points(random, 4, -5, 5), options, 2) == "");
            CHECK(check(random_points(random, 3, -1e6, 1e6), options, 2) == "");
        }
    }

    // Images then need three doubles: such planes were all decided exactly, for minutes a cell.
    TEST_CASE("domains: a flat set with noise in a thin periodic box") {
        test::Random random(11);
        Options options = domain_options();
        options.box = Box{{-10, -10, -0.5}, {10, 10, 0.5}};
        options.periodic = {false, false, true};
        CHECK(check({1, 2, 1e-30, 5, 3, -1e-17, -4, -3, 3e-22}, options, 3) == "");
        Coordinates many;
        for (int i = 0; i < 60; ++i)
            many.insert(many.end(), {random.uniform(-10, 10), random.uniform(-10, 10),
                                     random.uniform(-1, 1) * std::pow(10.0, random.uniform(-30, -15))});
        options.periodic = {true, true, true};
        const auto t = votess::tessellate(std::span<const double>(many), options);
        CHECK(test::check_domain(t) == "");
        CHECK(votess::verify(t, many).failure == "");
    }

    TEST_CASE("domains: the same seed one period on is a duplicate, one bit off it is not") {
        Options options = domain_options();
        options.periodic = {true, true, true};
        const Coordinates points{0.25, 0.25, 0.25, 1.25, 0.25, 0.25, 0.5, 0.75, 0.5, -1.75, 5.25, 0.25};
        const auto t = votess::tessellate(std::span<const double>(points), options);
        CHECK(t.stats().duplicates == 2);
        CHECK(std::ranges::equal(t.duplicate_of(), std::vector<std::int32_t>{-1, 0, -1, 0}));
        CHECK(test::check_domain(t) == "");
        // 1 - 1e-20 and 1 - 2e-20 are rounded to the same double, like 0 - ulp.
        const Coordinates near{-1e-20, 0.5, 0.5, -2e-20, 0.5, 0.5, 0.5, 0.5, 0.5};
        CHECK(check(near, options, 2) == "");
    }

    TEST_CASE("domains: one seed in a periodic cube has six faces, with itself") {
        Options options = domain_options();
        options.periodic = {true, true, true};
        const Coordinates point{0.1, 0.7, 0.3};
        const auto t = votess::tessellate(std::span<const double>(point), options);
        CHECK(std::ranges::equal(t.indices(), std::vector<std::int32_t>{0, 0, 0, 0, 0, 0}));
        const std::vector<std::int8_t> shifts{-1, 0, 0, 0, -1, 0, 0, 0, -1, 0, 0, 1, 0, 1, 0, 1, 0, 0};
        CHECK(std::ranges::equal(t.shifts(), shifts));
        CHECK(t.volumes()[0] == doctest::Approx(1).epsilon(1e-14));
    }

    TEST_CASE("domains: perfect lattices in periodic boxes") {
        Options options = domain_options();
        options.periodic = {true, true, true};
        for (const int length : {1, 2, 3, 5, 7}) {
            CAPTURE(length);
            const auto faces_are = [&](const Coordinates& points, std::size_t count) {
                const auto t = votess::tessellate(std::span<const double>(points), options);
                CHECK(test::check_domain(t) == "");
                CHECK(std::ranges::all_of(face_counts(t), [&](std::size_t c) { return c == count; }));
            };
            faces_are(lattice(length, {{0, 0, 0}}), 6);
            if (length % 2 == 1 && length > 1) continue;  // (i + 1/2) / length is rounded: no perfect lattice
            faces_are(lattice(length, {{0, 0, 0}, {0.5, 0.5, 0.5}}), 14);
            faces_are(lattice(length, {{0, 0, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}}), 12);
        }
    }

    TEST_CASE("domains: triclinic cells of few seeds, against exact half-spaces") {
        test::Random random(3);
        for (std::uint64_t round = 0; round < test::by_size(2, 1); ++round)
            for (const std::size_t n : {1, 2, 5}) {
                Options options = domain_options();
                options.box.reset();
                options.cell = random_cell(random);
                if (round % 2 == 1) std::swap(options.cell->a, options.cell->b);  // left-handed
                CAPTURE(round);
                CAPTURE(n);
                CHECK(check(random_points(random, n, -1, 2), options, 3) == "");
            }
        // Ties: a sheared lattice of integers.
        Options options = domain_options();
        options.box.reset();
        options.cell = votess::TriclinicBox{{0, 0, 0}, {2, 0, 0}, {1, 2, 0}, {-1, 1, 2}};
        CHECK(check({0, 0, 0, 1, 1, 0}, options, 4) == "");
    }

    TEST_CASE("domains: tilted cells of high aspect") {
        test::Random random(4);
        for (const double tilt : {-0.45, 0.45}) {
            Options options = domain_options();
            options.box.reset();
            options.cell = votess::TriclinicBox{{0.1, 0.2, 0.3}, {20, 0, 0}, {20 * tilt, 1, 0}, {20 * tilt, tilt, 1}};
            for (const std::size_t n : {1, 2, 8, 300}) {
                const Coordinates points = random_points(random, n, 0, 20);
                const auto t = votess::tessellate(std::span<const double>(points), options);
                CAPTURE(tilt);
                CAPTURE(n);
                CHECK(test::check_domain(t) == "");
            }
            CHECK(check(random_points(random, 1, 0, 20), options, 12) == "");
        }
    }

    TEST_CASE("domains: power diagrams of few seeds, against exact half-spaces") {
        test::Random random(5);
        for (std::uint64_t round = 0; round < test::by_size(3, 1); ++round)
            for (unsigned mask = 0; mask < 8; mask += 7) {
                Options options = domain_options();
                for (auto& axis : options.periodic) axis = mask != 0;
                const std::size_t n = 3 + round % 6;
                std::vector<double> weights(n);
                for (double& w : weights) w = random.uniform(-0.2, 0.2) * static_cast<double>(round % 3);
                options.weights = weights;
                CAPTURE(round);
                CAPTURE(mask);
                CHECK(check(random_points(random, n), options, mask != 0 ? 2 : 0) == "");
                // Weights of squared grid steps: bisectors fall together.
                for (double& w : weights) w = static_cast<double>(random.below(5)) / 16;
                CHECK(check(grid_points(random, n, 4, 0.25), options, mask != 0 ? 2 : 0) == "");
            }
    }

    TEST_CASE("domains: in a power diagram a flat cell's face is that of the seed behind") {
        // Bisectors of the outer two with the middle one both lie at x = 1/2: the middle cell has no interior.
        Options options = domain_options();
        const std::vector<double> weights{0, -0.0625, 0};
        options.weights = weights;
        for (const auto& points : {Coordinates{0.25, 0.5, 0.5, 0.5, 0.5, 0.5, 0.75, 0.5, 0.5},
                                   Coordinates{0.75, 0.5, 0.5, 0.5, 0.5, 0.5, 0.25, 0.5, 0.5}}) {
            const auto t = votess::tessellate(std::span<const double>(points), options);
            CHECK(t.status()[1] == votess::CellStatus::empty);
            CHECK(t.stats().empty_cells == 1);
            CHECK(std::ranges::count(t.neighbors(0), 2) == 1);
            CHECK(std::ranges::count(t.neighbors(0), 1) == 0);
            CHECK(check(points, options, 0) == "");
        }
    }

    TEST_CASE("domains: weights of seeds at one place") {
        Options options = domain_options();
        const Coordinates points{0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.2, 0.2, 0.2, 0.5, 0.5, 0.5};
        const std::vector<double> weights{0.01, 0.02, 0, 0.02};
        options.weights = weights;
        const auto t = votess::tessellate(std::span<const double>(points), options);
        CHECK(t.status()[0] == votess::CellStatus::empty);
        CHECK(t.status()[1] == votess::CellStatus::certified);
        CHECK(t.status()[3] == votess::CellStatus::duplicate);
        CHECK(std::ranges::equal(t.duplicate_of(), std::vector<std::int32_t>{-1, -1, -1, 1}));
        CHECK(t.stats().empty_cells == 2);
        CHECK(test::check_domain(t) == "");
    }

    TEST_CASE("domains: walls of any direction, against exact half-spaces") {
        test::Random random(6);
        for (std::uint64_t round = 0; round < test::by_size(10, 2); ++round) {
            Options options = domain_options();
            const std::size_t walls = 1 + round % 5;
            for (std::size_t w = 0; w < walls; ++w) {
                votess::Wall wall{{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}, 0};
                for (const double n : wall.normal) wall.offset += 0.5 * n;
                wall.offset += random.uniform(0.05, 0.4);
                options.walls.push_back(wall);
            }
            options.outside = votess::Outside::error;
            Coordinates inside;
            while (inside.size() < 21) {
                const Coordinates x = random_points(random, 1);
                const bool kept = std::ranges::all_of(options.walls, [&](const votess::Wall& w) {
                    return w.normal[0] * x[0] + w.normal[1] * x[1] + w.normal[2] * x[2] < w.offset - 1e-9;
                });
                if (kept) inside.insert(inside.end(), x.begin(), x.end());
            }
            CHECK(check(inside, options, 0) == "");
        }
        // An octahedron around a grid: its walls go through corners of cells, and some seeds lie on them.
        Options options = domain_options();
        options.box = test::cube(-2, 2);
        for (const double x : {-1, 1})
            for (const double y : {-1, 1})
                for (const double z : {-1, 1}) options.walls.push_back({{x, y, z}, 1});
        CHECK(check({0, 0, 0, 0.5, 0, 0, 0, 0.5, 0, 0.25, 0.25, 0.5, -0.5, 0, 0, 1, 0, 0}, options, 0) == "");
    }

    TEST_CASE("domains: a seed outside a wall is refused or dropped") {
        Options options = domain_options();
        options.walls.push_back({{1, 1, 1}, 1.5});
        const Coordinates points{0.1, 0.1, 0.1, 0.9, 0.9, 0.9, 0.5, 0.5, 0.5, 0.3, 0.6, 0.2};
        CHECK_THROWS_WITH_AS((void)votess::tessellate(std::span<const double>(points), options),
                             "point 1: (0.9, 0.9, 0.9) is outside wall 0 (1 x + 1 y + 1 z <= 1.5, -7 in lists), by "
                             "0.693: move it, or drop points outside (outside = drop)",
                             votess::Error);
        options.outside = votess::Outside::drop;
        const auto t = votess::tessellate(std::span<const double>(points), options);
        CHECK(t.status()[1] == votess::CellStatus::outside);
        CHECK(t.status()[2] == votess::CellStatus::certified);  // on the wall
        CHECK(t.stats().empty_cells == 1);
        CHECK(t.stats().box_volume == doctest::Approx(0.5).epsilon(1e-12));
        CHECK(test::check_domain(t) == "");
        CHECK(std::ranges::count(t.neighbors(2), -7) == 1);
    }

    TEST_CASE("domains: images of neighboring doubles, which rounding makes equal") {
        for (const std::array<bool, 3> periodic : {std::array{true, false, true}, {true, true, true}}) {
            Options options = domain_options();
            options.periodic = periodic;
            const double x = 0.6;
            const Coordinates points{0.1, 0.2, 0.3, std::nextafter(x, 1), 0.5, 0.5, x, 0.5, 0.5, 0.3, 0.8, 0.2};
            CHECK(check(points, options, 2) == "");
        }
    }

    TEST_CASE("domains: seeds outside of a box that is periodic along some axes") {
        Options options = domain_options();
        options.periodic = {true, false, true};
        options.outside = votess::Outside::drop;
        // Beyond x is wrapped, beyond y is dropped.
        const Coordinates points{0.1, 0.2,  0.3, 1.6, 0.5, 0.5, 0.4, 1.2, 0.1,
                                 0.7, -0.1, 0.9, 0.6, 0.5, 0.5, 0.3, 0.8, 0.2};
        const auto t = votess::tessellate(std::span<const double>(points), options);
        CHECK(t.status()[1] == votess::CellStatus::certified);
        CHECK(t.status()[2] == votess::CellStatus::outside);
        CHECK(t.status()[3] == votess::CellStatus::outside);
        CHECK(t.stats().empty_cells == 2 + t.stats().duplicates);
        CHECK(test::check_domain(t) == "");
        CHECK(votess::verify(t, points).failure == "");
        // The same rows as without them.
        const Coordinates inside{0.1, 0.2, 0.3, 1.6, 0.5, 0.5, 0.6, 0.5, 0.5, 0.3, 0.8, 0.2};
        CHECK(check(inside, options, 2) == "");
        const auto same = votess::tessellate(std::span<const double>(inside), options);
        const std::array<std::int32_t, 4> from{0, 1, 4, 5};
        for (std::size_t i = 0; i < from.size(); ++i)
            CHECK(t.volumes()[static_cast<std::size_t>(from[i])] == doctest::Approx(same.volumes()[i]).epsilon(1e-14));
    }

    // Walls and box both drop seeds; the first seed is not in the domain that both leave.
    TEST_CASE("domains: seeds outside of a box with more walls") {
        Options options = domain_options();
        options.outside = votess::Outside::drop;
        options.walls.push_back({{1, 0, 0}, 0.75});
        const Coordinates points{-0.5, 0.5, 0.5, 0.9, 0.5, 0.5, 0.25, 0.5, 0.5, 0.5, 0.5, 0.5};
        const auto t = votess::tessellate(std::span<const double>(points), options);
        CHECK(t.stats().empty_cells == 2);
        CHECK(t.stats().box_volume == doctest::Approx(0.75).epsilon(1e-14));
        CHECK(test::check_domain(t) == "");
    }

    TEST_CASE("domains: without a box a polyhedron is its own bounds") {
        Options options = domain_options();
        options.box.reset();
        for (const double sign : {-1, 1})
            for (std::size_t k = 0; k < 3; ++k) {
                votess::Wall wall{{0, 0, 0}, 5};
                wall.normal[k] = sign;
                options.walls.push_back(wall);
            }
        const Coordinates points{0.1, 0.1, 0.1, 0.2, -0.1, 0};
        const auto t = votess::tessellate(std::span<const double>(points), options);
        CHECK(t.stats().box_volume == doctest::Approx(1000).epsilon(1e-12));
        CHECK(test::check_domain(t) == "");
        CHECK(std::ranges::all_of(t.indices(), [](std::int32_t id) { return id >= 0 || id <= -7; }));
    }

    TEST_CASE("domains: larger periodic sets fill the box for any number of threads") {
        for (const auto& set : {test::uniform(test::by_size(20000, 2000), 7),
                                test::clustered(test::by_size(20000, 2000), 8), test::uniform(10, 9)}) {
            Options options = domain_options();
            options.periodic = {true, true, true};
            const auto t = votess::tessellate(std::span<const double>(set.points), options);
            CAPTURE(set.name);
            CHECK(test::check_domain(t) == "");
            options.threads = 3;
            const auto again = votess::tessellate(std::span<const double>(set.points), options);
            CHECK(test::check_identical(t, again) == "");
        }
    }
}

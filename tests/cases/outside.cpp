// The option `outside`: seeds beyond the box, the cell or walls are refused or dropped.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/scattered.hpp"
#include "support/text.hpp"

namespace {

using test::Coordinates;
using test::has;
using test::refusal;
using votess::Options;
using enum votess::CellStatus;

std::vector<votess::CellStatus> statuses(const votess::Tessellation& t) {
    return {t.status().begin(), t.status().end()};
}

Options dropping(const std::optional<votess::Box>& box = test::unit_box()) {
    Options options = test::all_options(box);
    options.outside = votess::Outside::drop;
    return options;
}

// Counts the cells of seeds in the unit box or outside.
std::size_t cells_of(const test::Scattered& s, const votess::Tessellation& t, bool outside) {
    std::size_t cells = 0;
    for (std::size_t i = 0; i < t.size(); ++i) {
        bool beyond = false;
        for (std::size_t k = 0; k < 3; ++k) beyond = beyond || !(s.points[3 * i + k] >= 0 && s.points[3 * i + k] <= 1);
        if (beyond == outside && t.status()[i] == certified) ++cells;
    }
    return cells;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("outside: seeds that are kept have exactly the parts of their cells inside") {
        test::Scattered s;
        for (int kind = 0; kind < test::kinds_of_scattered; ++kind)
            for (const bool weighted : {false, true})
                for (const double far : {0.3, 5.0}) {
                    if (test::reduced() && weighted == (far < 1)) continue;
                    CAPTURE(kind);
                    CAPTURE(weighted);
                    CAPTURE(far);
                    test::scatter(kind, 24, far, weighted, 7 + static_cast<std::uint64_t>(kind), s);
                    const auto t = votess::tessellate(s.points, s.options);
                    CHECK(test::check_against_half_spaces(t, s.points, s.options) == "");
                    CHECK(test::check_domain(t) == "");
                    CHECK(votess::verify(t, s.points).failure == "");
                    if (weighted || far < 1) CHECK(cells_of(s, t, true) > 0);
                    CHECK(std::ranges::find(t.status(), outside) == t.status().end());
                }
    }

    // p' = c + s (p - c) and w' = s^2 q^2 - s (q^2 - w) with q = |p - c| leave every power as it was, times s and plus
    // the same. All numbers here are exact.
    TEST_CASE("outside: a Laguerre diagram whose seeds are moved out is the same") {
        enum Domain { box, walls, cell, lattice };
        for (const Domain domain : {box, walls, cell, lattice})
            for (const double s : {1.25, 2.0, 8.0}) {
                if (test::reduced() && s != 2) continue;
                CAPTURE(domain);
                CAPTURE(s);
                test::Random random(3);
                Coordinates points, moved;
                std::vector<double> weights, moved_weights;
                for (std::size_t i = 0; i < 343; ++i) {
                    double square = 0;
                    for (std::size_t k = 0, rest = i; k < 3; ++k, rest /= 7) {
                        const double x = domain == lattice
                                             ? (static_cast<double>(rest % 7) - 3) / 8
                                             : static_cast<double>(random.below(1 << 16)) / (1 << 16) - 0.5;
                        square += x * x;
                        points.push_back(x);
                        moved.push_back(s * x);
                    }
                    const double w = domain == lattice ? 0 : static_cast<double>(random.below(1 << 10)) / (1 << 16);
                    weights.push_back(w);
                    moved_weights.push_back(s * s * square - s * (square - w));
                }
                Options options = test::all_options(test::cube(-0.5, 0.5));
                options.want.vertices = options.want.faces = true;
                options.outside = votess::Outside::keep;
                if (domain == walls) options.walls = votess::sphere_walls({0, 0, 0}, 0.4, 12);
                if (domain == cell) {
                    options.box.reset();
                    options.cell = {{-0.375, -0.25, -0.25}, {0.5, 0.125, 0}, {0, 0.5, 0.125}, {0.25, 0, 0.5}, {}};
                }
                options.weights = weights;
                const auto t = votess::tessellate(points, options);
                options.weights = moved_weights;
                const auto other = votess::tessellate(moved, options);
                CHECK(test::rows_of(other) == test::rows_of(t));
                double worst = 0;
                for (std::size_t i = 0; i < t.size(); ++i)
                    if (t.volumes()[i] > 1e-9)
                        worst = std::max(worst, std::abs(other.volumes()[i] - t.volumes()[i]) / t.volumes()[i]);
                CHECK(worst <= 1e-12);
                CHECK(std::ranges::equal(t.face_counts(), other.face_counts()));
                CHECK(t.vertices().size() == other.vertices().size());
                CHECK(votess::verify(other, moved).failure == "");
            }
    }

    TEST_CASE("outside: many seeds that are kept, with all arrays") {
        test::Scattered s;
        for (int kind = 0; kind < test::kinds_of_scattered; ++kind)
            for (const bool weighted : {false, true}) {
                CAPTURE(kind);
                CAPTURE(weighted);
                test::scatter(kind, test::by_size(1500, 300), 0.2, weighted, 40 + static_cast<std::uint64_t>(kind), s);
                s.options.want.vertices = s.options.want.faces = true;
                s.options.threads = 2;
                const auto t = votess::tessellate(s.points, s.options);
                CHECK(test::check_domain(t) == "");
                CHECK(votess::verify(t, s.points).failure == "");
            }
    }

    // A seed on a wall has no mirror image there. With weights a bisector may pass through it, in the wall.
    TEST_CASE("outside: bisectors that lie in walls, also of seeds on these") {
        enum Domain { box, wall, periodic };
        for (const Domain domain : {box, wall, periodic}) {
            test::Random random(30 + static_cast<std::uint64_t>(domain));
            for (std::size_t set = 0; set < test::by_size(400, 60); ++set) {
                CAPTURE(domain);
                CAPTURE(set);
                Coordinates points;
                std::vector<double> weights;
                for (std::size_t i = 2 + random.below(9); i-- > 0;) {
                    for (int k = 0; k < 3; ++k) points.push_back(0.5 * static_cast<double>(random.below(5)));
                    weights.push_back(0.25 * static_cast<double>(random.below(3)));
                }
                votess::Box bounds{};
                for (std::size_t k = 0; k < 3; ++k) {
                    bounds.lower[k] = 0.5 * static_cast<double>(random.below(2));
                    bounds.upper[k] = bounds.lower[k] + 0.5 * static_cast<double>(1 + random.below(3));
                }
                Options options = test::all_options(bounds);
                options.outside = votess::Outside::keep;
                options.weights = weights;
                if (domain == periodic) options.periodic[0] = true;
                if (domain == wall) {
                    options.walls.push_back({{1, 0, 0}, bounds.upper[0]});
                    options.box->upper[0] += 1;
                }
                const auto t = votess::tessellate(points, options);
                CHECK(votess::verify(t, points).failure == "");
                CHECK(test::check_domain(t) == "");
            }
        }
    }

    // The bisector of a seed and its mirror image is the wall, which has the face.
    TEST_CASE("outside: mirror images in walls are kept and have no cell") {
        for (const bool walls : {false, true}) {
            const auto set = test::uniform(60, 5);
            Coordinates points = set.points;
            for (std::size_t i = 0; i < set.size(); ++i)
                for (std::size_t k = 0; k < 3; ++k) points.push_back(k == 0 ? -points[3 * i] : points[3 * i + k]);
            Options options = test::all_options(test::unit_box());
            options.outside = votess::Outside::keep;
            if (walls) {
                options.box = test::cube(-1, 2);
                options.walls = votess::sphere_walls({0.5, 0.5, 0.5}, 2, 40);  // so many are postponed
                options.walls.push_back({{-1, 0, 0}, 0});
            }
            const auto t = votess::tessellate(points, options);
            CHECK(test::check_right(points, options) == "");
            CHECK(std::ranges::count(t.status(), empty) == static_cast<std::ptrdiff_t>(set.size()));
            options.outside = votess::Outside::drop;
            CHECK(test::rows_of(votess::tessellate(points, options)) == test::rows_of(t));
        }
    }

    TEST_CASE("outside: how far a seed may be that is kept") {
        Options options = test::all_options(test::unit_box());
        options.outside = votess::Outside::keep;
        Coordinates points{0.25, 0.5, 0.5, 0.75, 0.5, 0.25, 1e12, 0.5, 0.5, 0.5, -4e11, 0.5};
        CHECK(test::check_right(points, options) == "");
        // Weights that bring the cells of both into the domain.
        const std::vector<double> weights{0, 0, 1e24 - 1.5e12, 1.6e23};
        options.weights = weights;
        CHECK(test::check_right(points, options) == "");
        options.weights = {};
        points[6] = 2e12;
        CHECK(has(refusal(points, options), "point 2: x = 2e+12 is too far outside to be kept"));
    }

    TEST_CASE("outside: a seed beyond the box is refused") {
        const Options options = test::all_options(test::unit_box());
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const double value : {2.25, -0.125, std::nextafter(1.0, 2.0), -0x1p-1074}) {
                Coordinates points = test::uniform(300, 72).points;
                points[3 * 217 + axis] = value;
                points[3 * 290] = 7;
                const auto message = refusal(points, options);
                CAPTURE(message);
                CHECK(has(message, "217"));
                if (value == 2.25) CHECK(has(message, "2.25"));
                if (value == -0.125) CHECK(has(message, "-0.125"));
                CHECK_FALSE(has(message, "290"));
            }
        CHECK(refusal({0, 0, 0, 1, 1, 1, 0, 1, 0}, options) == "");  // the walls belong to the box
    }

    TEST_CASE("outside: the error states how far, and of what") {
        const auto distance_in = [](const std::string& message) {
            const auto at = message.find(", by ");
            return at == std::string::npos ? -1 : std::stod(message.substr(at + 5));
        };
        test::Random random(17);
        for (int run = 0; run < 60; ++run) {
            const double scale = std::ldexp(1, static_cast<int>(random.below(800)) - 400);
            const double beyond = scale * std::ldexp(random.uniform(0.5, 1), -static_cast<int>(random.below(30)));
            const auto axis = static_cast<std::size_t>(random.below(3));
            const double sign = random.below(2) == 0 ? -1 : 1;
            // Box -scale..scale.
            Coordinates points(9, 0.25 * scale);
            points[3] = points[7] = -0.5 * scale;
            points[6 + axis] = sign * (scale + beyond);
            Options options;
            options.box = test::cube(-scale, scale);
            std::string message = refusal(points, options);
            CAPTURE(message);
            CHECK(has(message, "point 2: " + std::string(1, "xyz"[axis]) + " = "));
            CHECK(distance_in(message) == doctest::Approx(beyond).epsilon(0.01));
            const bool rounded = beyond <= 1e-6 * 2 * scale;  // as a file may round
            CHECK(has(message, rounded ? "may be rounded: keep" : "Options::outside = drop"));
            // The same box as a cell.
            options.box.reset();
            options.cell = {{-scale, -scale, -scale}, {2 * scale, 0, 0}, {0, 2 * scale, 0}, {0, 0, 2 * scale}, {}};
            message = refusal(points, options);
            CHECK(has(message, "wall " + std::to_string(-1 - 2 * static_cast<int>(axis) - (sign > 0)) + ")"));
            CHECK(distance_in(message) == doctest::Approx(beyond).epsilon(0.01));
            // Walls whose normals have the length 7.
            options = {};
            options.walls = {{{-1, 0, 0}, 2 * scale}, {{2, 3, -6}, 7 * scale}, {{-2, -3, 6}, 7 * scale}};
            for (std::size_t k = 0; k < 3; ++k)
                points[6 + k] = sign * options.walls[1].normal[k] / 7 * (scale + beyond);
            message = refusal(points, options);
            CHECK(has(message, sign > 0 ? "wall 1 (2 x + 3 y + -6 z <= " : "wall 2 (-2 x + -3 y + 6 z <= "));
            CHECK(has(message, sign > 0 ? ", -8 in lists)" : ", -9 in lists)"));
            CHECK(distance_in(message) == doctest::Approx(beyond).epsilon(0.01));
        }
        // Beyond a wall by less than rounding shows: 3 times 0.1 is more than 0.3.
        Options options = test::all_options(test::unit_box());
        options.walls = {{{3, 0, 0}, 0.3}};
        CHECK(has(refusal({0.1, 0.5, 0.5}, options), ", by less than "));
        CHECK(distance_in(refusal({-1e308, 0, 0, 1e308, 0, 0}, test::all_options(test::cube(-1e308, 0.9e308)))) > 0);
    }

    TEST_CASE("outside: a seed beyond a wall is refused or dropped") {
        Options options = test::all_options(test::unit_box());
        options.walls.push_back({{1, 1, 1}, 1.5});
        const Coordinates points{0.1, 0.1, 0.1, 0.9, 0.9, 0.9, 0.5, 0.5, 0.5, 0.3, 0.6, 0.2};
        CHECK(
            refusal(points, options) ==
            "point 1: (0.9, 0.9, 0.9) is outside wall 0 (1 x + 1 y + 1 z <= 1.5, -7 in lists), by "
            "0.693: move it, or drop points outside (Options::outside = drop) or keep them (Options::outside = keep)");
        options.outside = votess::Outside::drop;
        const auto t = votess::tessellate(points, options);
        CHECK(statuses(t) == std::vector{certified, outside, certified, certified});  // the third is on the wall
        CHECK(t.stats().empty_cells == 1);
        CHECK(t.stats().box_volume == doctest::Approx(0.5).epsilon(1e-12));
        CHECK(std::ranges::count(t.neighbors(2), -7) == 1);
        CHECK(test::check_right(points, options) == "");
    }

    TEST_CASE("outside: along an axis that is periodic, seeds are wrapped") {
        Options options = dropping();
        options.periodic = {true, false, true};
        const Coordinates points{0.1, 0.2,  0.3, 1.6, 0.5, 0.5, 0.4, 1.2, 0.1,
                                 0.7, -0.1, 0.9, 0.6, 0.5, 0.5, 0.3, 0.8, 0.2};
        const auto t = votess::tessellate(points, options);
        CHECK(t.status()[1] == certified);
        CHECK(t.status()[2] == outside);
        CHECK(t.status()[3] == outside);
        CHECK(t.stats().empty_cells == 2 + t.stats().duplicates);
        CHECK(test::check_right(points, options) == "");
        // The same cells as without them.
        const Coordinates inside{0.1, 0.2, 0.3, 1.6, 0.5, 0.5, 0.6, 0.5, 0.5, 0.3, 0.8, 0.2};
        CHECK(test::check_right(inside, options) == "");
        const auto same = votess::tessellate(inside, options);
        const std::array<std::size_t, 4> from{0, 1, 4, 5};
        for (std::size_t i = 0; i < from.size(); ++i)
            CHECK(t.volumes()[from[i]] == doctest::Approx(same.volumes()[i]).epsilon(1e-14));
    }

    TEST_CASE("outside: of a cell it is decided exactly") {
        // The wall across c goes through (1/3, 1/3, 1) as rounded: its normal has no doubles.
        Options options = test::all_options();
        options.cell = {{}, {1, 0, 1.0 / 3}, {0, 1, 1.0 / 7}, {1.0 / 3, 1.0 / 3, 1}, {true, true, false}};
        const Coordinates on{1.0 / 3, 1.0 / 3, 1, 0.5, 0.5, 0.5};
        CHECK(refusal(on, options) == "");
        Coordinates above = on;
        above[2] = std::nextafter(above[2], 2);
        CHECK(refusal(above, options).starts_with("point 0: ("));
        CHECK(has(refusal(above, options), "is outside of the cell"));
        options.outside = votess::Outside::drop;
        const auto t = votess::tessellate(above, options);
        CHECK(statuses(t) == std::vector{outside, certified});
        CHECK(t.volumes()[1] == doctest::Approx(t.stats().box_volume).epsilon(1e-12));
        above[2] = 1e300;  // more periods away than there are
        CHECK(votess::tessellate(above, options).status()[0] == outside);
        options = dropping();
        options.periodic = {true, false, false};
        above[0] = 1e300;
        CHECK(votess::tessellate(above, options).status()[0] == outside);
    }

    TEST_CASE("outside: a dropped seed may lie beyond what scaling leaves finite") {
        Options options = dropping(std::nullopt);
        for (std::size_t k = 0; k < 3; ++k)
            for (const double sign : {-1, 1}) {
                votess::Wall wall{{0, 0, 0}, 0x1p-300};
                wall.normal[k] = sign;
                options.walls.push_back(wall);
            }
        const auto t =
            votess::tessellate(Coordinates{0, 0, 0, 0x1p900, 0, 0, 0, -0x1p1000, 0, 0x1p-301, 0, 0}, options);
        CHECK(statuses(t) == std::vector{certified, outside, outside, certified});
        CHECK(t.neighbors(0).size() == 6);
    }
}

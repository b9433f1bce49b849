// The option `box`, the default box, and coordinates at the limits of exact arithmetic.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/text.hpp"

namespace {

using test::has;
using test::refusal;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("box: the default of one seed is half the largest coordinate around it, 0.5 around the origin") {
        const auto at_origin = votess::tessellate(test::Coordinates{0, 0, 0}, test::all_options());
        CHECK(at_origin.box().lower == std::array{-0.5, -0.5, -0.5});
        CHECK(at_origin.box().upper == std::array{0.5, 0.5, 0.5});
        CHECK(at_origin.volumes()[0] == doctest::Approx(1).epsilon(1e-14));
        const auto t = votess::tessellate(test::Coordinates{1, -4, 2}, test::all_options());
        CHECK(t.box().lower == std::array{-1.0, -6.0, 0.0});
        CHECK(t.box().upper == std::array{3.0, -2.0, 4.0});
        CHECK(t.volumes()[0] == doctest::Approx(64).epsilon(1e-14));
    }

    TEST_CASE("box: the default moves bounds out by half of the longest side over the cube root of N") {
        const test::Coordinates points{0, 0,   0, 8, 1,   2, 4, 0.5, 2, 4, 0.5, 1,
                                       1, 0.5, 1, 2, 0.5, 1, 3, 0.5, 1, 5, 0.5, 1};
        const auto t = votess::tessellate(points, test::all_options());
        for (std::size_t a = 0; a < 3; ++a) {
            const double upper[] = {8, 1, 2};
            CHECK(std::abs(t.box().lower[a] + 2) <= 1e-12);
            CHECK(std::abs(t.box().upper[a] - upper[a] - 2) <= 1e-12);
        }
        CHECK(test::check_exact(t, points) == "");
    }

    TEST_CASE("box: empty and inverted ones are refused, and bounds at the wrong infinity") {
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const auto& [lower, upper] :
                 {std::pair{0.5, 0.5}, std::pair{0.75, 0.25}, std::pair{not_a_number, 1.0},
                  std::pair{0.0, not_a_number}, std::pair{infinity, 1.0}, std::pair{0.0, -infinity}}) {
                votess::Options options = test::all_options(test::unit_box());
                options.box->lower[axis] = lower;
                options.box->upper[axis] = upper;
                CAPTURE(lower);
                CAPTURE(upper);
                CHECK(refusal({0.5, 0.5, 0.5}, options) != "");
                CHECK(refusal({}, options) != "");
            }
    }

    TEST_CASE("box: walls that leave nothing of a box around the points are named, not a box") {
        votess::Options options;
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const double sign : {-1.0, 1.0}) {
                votess::Wall wall{{}, -5};
                wall.normal[axis] = sign;
                options.walls = {wall};
                for (const auto outside : {votess::Outside::error, votess::Outside::drop, votess::Outside::keep}) {
                    options.outside = outside;
                    const std::string message = refusal({0.5, 0.5, 0.5, -0.5, 0.25, 0.75}, options);
                    CHECK(has(message, "walls: they leave nothing of the box around the points: "));
                    CHECK(!has(message, "Options::box"));
                }
            }
    }

    TEST_CASE("box: bounds, walls, normals and weights that scaling would round are refused") {
        votess::Options options = test::all_options(votess::Box{{0x1p-1000, 0, 0}, {0x1p100, 0x1p100, 0x1p100}});
        CHECK(has(refusal({1, 1, 1}, options), "box: lower x"));
        options.box = votess::Box{{0, 0, -0x1p100}, {0x1p100, 0x1p100, 0x1p-1000}};
        CHECK(has(refusal({1, 1, -1}, options), "box: upper z"));
        options.box = test::cube(0, 0x1p100);
        CHECK(has(refusal({1, 1, 0x1p-1000}, options), "point 0: z"));
        options.walls = {{{-1, 0, 0}, -0x1p-1000}};
        CHECK(has(refusal({1, 1, 1}, options), "wall 0"));
        options.walls = {{{0, 0, 1}, 0x1p99}, {{0x1p1000, 0x1p-1074, 0}, 0x1p1020}};
        CHECK(has(refusal({1, 1, 1}, options), "wall 1"));
        options.walls.clear();
        const std::vector<double> weights{0, 0x1p-1000}, radii{0, 0x1p-450};
        options.weights = weights;
        CHECK(has(refusal({1, 1, 1, 2, 2, 2}, options), "weight 1"));
        options.weights = {};
        options.radii = radii;
        CHECK(has(refusal({1, 1, 1, 2, 2, 2}, options), "radius 1"));
    }

    TEST_CASE("box: coordinates beyond the range of exact arithmetic are refused, never guessed") {
        const double huge = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::denorm_min();
        for (const test::Coordinates& points :
             {test::Coordinates{-huge, 0, 0, huge, 1, 2}, test::Coordinates{0, 0, 0, tiny, 0, 0, 0, tiny, tiny},
              test::Coordinates{huge, huge, huge}, test::Coordinates{0, 0, 0, 1, 1, 1, 1, tiny, 0}}) {
            if (refusal(points, test::all_options()) != "") continue;
            CHECK(test::check_invariants(votess::tessellate(points, test::all_options()), points, true) == "");
        }
    }

    // In its units their volumes would be far below the least double.
    TEST_CASE("box: cells far smaller than their box are measured as in a small one") {
        test::Coordinates points = test::uniform(60, 3).points;
        for (double& x : points) x *= 3;
        points.insert(points.end(), {1, 2, 0x1p55});
        const std::size_t far = points.size() / 3 - 1;
        const auto run = [&](int exponent) {
            votess::Options options = test::all_options(votess::Box{{0, 0, 0}, {3, 3, std::ldexp(1.0, exponent)}});
            options.want.surfaces = options.want.radii = true;
            return votess::tessellate(points, options);
        };
        const auto small = run(60);
        const auto near = [](std::span<const double> a, std::span<const double> b) {
            return std::ranges::equal(
                a, b, [](double x, double y) { return std::abs(x - y) <= 1e-11 * std::max(std::abs(y), 1e-3); });
        };
        for (const int exponent : {63, 64, 200, 448}) {
            CAPTURE(exponent);
            const auto t = run(exponent);
            REQUIRE(test::rows_of(t) == test::rows_of(small));
            const auto entries = static_cast<std::size_t>(t.indptr()[far]);
            CHECK(near(t.volumes().first(far), small.volumes().first(far)));
            CHECK(near(t.centroids().first(3 * far), small.centroids().first(3 * far)));
            CHECK(near(t.surface_areas().first(far), small.surface_areas().first(far)));
            CHECK(near(t.security_radii().first(far), small.security_radii().first(far)));
            CHECK(near(t.face_areas().first(entries), small.face_areas().first(entries)));
            CHECK(votess::verify(t, points).failure == "");
        }
        votess::Options options = test::all_options(votess::Box{{0, 0, 0}, {3, 3, 0x1p510}});
        CHECK(has(refusal(points, options), "Options::box: its sides are from 3 to "));
        options.want = {.neighbors = true, .volumes = false};
        CHECK(test::rows_of(votess::tessellate(points, options)).size() == points.size() / 3);
    }
}

// Walls around spheres, cylinders and cones.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using Vector = std::array<double, 3>;
constexpr double pi = std::numbers::pi;

// By what share the polyhedron in the box is larger than the body; the cells must fill it.
double excess(const std::vector<votess::Wall>& walls, const votess::Box& box, const Vector& middle, double size,
              double volume) {
    test::Random random(31);
    std::vector<double> points;
    for (int i = 0; i < 200; ++i)
        for (const double x : middle) points.push_back(x + size * random.uniform(-0.3, 0.3));
    votess::Options options = test::all_options(box);
    options.walls = walls;
    const auto t = votess::tessellate(std::span<const double>(points), options);
    CHECK(votess::verify(t, points).failure == "");
    CHECK(std::abs(t.stats().volume_sum - t.stats().box_volume) <= 1e-9 * t.stats().box_volume);
    return t.stats().box_volume / volume - 1;
}

template <class Make>
std::string refusal(const Make& make) {
    try {
        (void)make();
    } catch (const votess::Error& error) {
        CHECK(error.code() == votess::ErrorCode::invalid_argument);
        return error.what();
    }
    return "";
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("round walls: they touch the body, and hold little more") {
        const Vector center{3, -2, 5};
        for (const std::size_t faces : {30, 300}) {
            CAPTURE(faces);
            const auto sphere = votess::sphere_walls(center, 0.75, faces);
            REQUIRE(sphere.size() == faces);
            for (const auto& [n, d] : sphere) {
                CHECK(std::hypot(n[0], n[1], n[2]) == doctest::Approx(1).epsilon(1e-14));
                CHECK(d - n[0] * center[0] - n[1] * center[1] - n[2] * center[2] ==
                      doctest::Approx(0.75).epsilon(1e-13));
            }
            const double more = excess(sphere, {{0, -5, 2}, {6, 1, 8}}, center, 0.75, 4 * pi / 3 * std::pow(0.75, 3));
            CHECK(more > 2.5 / static_cast<double>(faces));
            CHECK(more < 4.0 / static_cast<double>(faces));
        }
        for (const Vector& axis : {Vector{0, 0, 2}, Vector{1, -2, 3e-7}, Vector{1e-200, 1e-200, 1e-200}}) {
            CAPTURE(axis[2]);
            const auto cylinder = votess::cylinder_walls(center, axis, 0.5, 32);
            REQUIRE(cylinder.size() == 32);
            const double largest = std::max({std::abs(axis[0]), std::abs(axis[1]), std::abs(axis[2])});
            for (const auto& [n, d] : cylinder) {
                CHECK(std::abs(n[0] * axis[0] + n[1] * axis[1] + n[2] * axis[2]) <= 1e-15 * 3 * largest);
                CHECK(d - n[0] * center[0] - n[1] * center[1] - n[2] * center[2] ==
                      doctest::Approx(0.5).epsilon(1e-13));
            }
        }
        const double share = pi * pi / (3 * 32 * 32);
        const double more = excess(votess::cylinder_walls(center, {0, 0, -1}, 0.5, 32), {{0, -5, 4}, {6, 1, 6}}, center,
                                   0.5, 2 * pi * 0.25);
        CHECK(more == doctest::Approx(share).epsilon(0.02));
        // From the apex at z = 0 up to z = 1, a half angle of 30 degrees.
        const double angle = pi / 6, base = std::tan(angle);
        const double cone = excess(votess::cone_walls({0, 0, 0}, {0, 0, 1}, angle, 32), {{-2, -2, -2}, {2, 2, 1}},
                                   {0, 0, 0.7}, 0.3, pi * base * base / 3);
        CHECK(cone == doctest::Approx(share).epsilon(0.02));
    }

    TEST_CASE("round walls: what is refused") {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        const auto has = [](const std::string& message, const char* what) {
            return message.find(what) != std::string::npos;
        };
        CHECK(has(refusal([&] { return votess::sphere_walls({0, nan, 0}, 1, 9); }), "center holds nan"));
        CHECK(has(refusal([&] { return votess::sphere_walls({0, 0, 0}, 0, 9); }), "radius 0"));
        CHECK(has(refusal([&] { return votess::sphere_walls({0, 0, 0}, nan, 9); }), "radius nan"));
        CHECK(has(refusal([&] { return votess::sphere_walls({0, 0, 0}, 1, 3); }), "3 faces"));
        CHECK(has(refusal([&] { return votess::sphere_walls({0, 0, 0}, 1, 1000001); }), "1000001 faces"));
        CHECK(has(refusal([&] { return votess::cylinder_walls({0, 0, 0}, {0, 0, 0}, 1, 9); }), "axis is 0"));
        CHECK(has(refusal([&] { return votess::cylinder_walls({0, 0, 0}, {0, 0, 1}, 1, 2); }), "2 faces"));
        CHECK(has(refusal([&] { return votess::cone_walls({0, 0, 0}, {0, 0, 1}, 1.6, 9); }), "angle 1.6"));
        CHECK(has(refusal([&] { return votess::cone_walls({0, 0, 0}, {0, 0, 1}, 0, 9); }), "angle 0"));
    }
}

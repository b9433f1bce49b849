// The option `walls`, and the walls around spheres, cylinders and cones.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/text.hpp"

namespace {

using test::Coordinates;
using votess::Options;
using Vector = std::array<double, 3>;
constexpr double pi = std::numbers::pi;

// A wedge as thin as e with its edge at x = -1: |z| <= e (1 + x), x <= 1, |y| <= 1.
std::vector<votess::Wall> wedge(double e) {
    return {{{-e, 0, 1}, e}, {{-e, 0, -1}, e}, {{1, 0, 0}, 1}, {{0, 1, 0}, 1}, {{0, -1, 0}, 1}};
}

bool touches_no_box(const votess::Tessellation& t) {
    return std::ranges::all_of(t.indices(), [](std::int32_t id) { return id >= 0 || id <= -7; });
}

// Returns by what share the polyhedron in the box is larger than the body. The cells must fill it.
double excess(const std::vector<votess::Wall>& walls, const votess::Box& box, const Vector& middle, double size,
              double volume) {
    test::Random random(31);
    Coordinates points;
    for (int i = 0; i < 200; ++i)
        for (const double x : middle) points.push_back(x + size * random.uniform(-0.3, 0.3));
    Options options = test::all_options(box);
    options.walls = walls;
    const auto t = votess::tessellate(points, options);
    CHECK(votess::verify(t, points).failure == "");
    CHECK(std::abs(t.stats().volume_sum - t.stats().box_volume) <= 1e-9 * t.stats().box_volume);
    return t.stats().box_volume / volume - 1;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("walls: without a box a polyhedron is its own bounds") {
        Options options = test::all_options();
        const double ulp = 0x1p-52;
        for (const double sign : {-1, 1})
            for (std::size_t k = 0; k < 3; ++k) {
                votess::Wall wall{{0, 0, 0}, 5};
                wall.normal[k] = sign;
                options.walls.push_back(wall);
            }
        const Coordinates points{0.1, 0.1, 0.1, 0.2, -0.1, 0};
        const auto t = votess::tessellate(points, options);
        CHECK(t.stats().box_volume == doctest::Approx(1000).epsilon(1e-12));
        CHECK(test::check_domain(t) == "");
        CHECK(touches_no_box(t));
        // A small one, far from 0.
        for (std::size_t w = 0; w < 6; ++w) options.walls[w].offset = w < 3 ? -1 : 1 + 4 * ulp;
        const Coordinates near{1 + ulp, 1 + ulp, 1 + ulp, 1 + 3 * ulp, 1 + 3 * ulp, 1 + 2 * ulp};
        const auto small = votess::tessellate(near, options);
        CHECK(small.stats().box_volume == doctest::Approx(64 * ulp * ulp * ulp).epsilon(1e-10));
        CHECK(touches_no_box(small));
        CHECK(votess::verify(small, near).failure == "");
    }

    TEST_CASE("walls: without a box walls at any angle bound themselves") {
        for (const double e : {1e-3, 1e-8, 1e-9, 1e-10, 1e-15, 0x1p-70, 0x1p-105}) {
            CAPTURE(e);
            Options options = test::all_options();
            options.walls = wedge(e);
            const Coordinates points{0.5, 0, 0, 0.75, 0.25, 0};  // their own bounds end far from the edge
            const auto t = votess::tessellate(points, options);
            const double exact = 8 * e;  // 2 * integral of 2 e (1 + x)
            CHECK(t.stats().box_volume == doctest::Approx(exact).epsilon(1e-10));
            CHECK(t.volumes()[0] + t.volumes()[1] == doctest::Approx(exact).epsilon(1e-10));
            CHECK(t.box().lower[0] <= -1);
            CHECK(t.box().lower[0] == doctest::Approx(-1).epsilon(0.01));
            CHECK(t.box().upper[0] >= 1);
            CHECK(t.box().upper[0] == doctest::Approx(1).epsilon(0.01));
            CHECK(t.box().upper[2] >= 2 * e);
            CHECK(t.box().upper[2] == doctest::Approx(2 * e).epsilon(0.01));
            CHECK(touches_no_box(t));
            CHECK(votess::verify(t, points).failure == "");
            // A box around it leaves the same cells.
            options.box = votess::Box{{-2, -2, -1}, {2, 2, 1}};
            CHECK(test::check_right(points, options) == "");
            CHECK(test::rows_of(votess::tessellate(points, options)) == test::rows_of(t));
        }
    }

    TEST_CASE("walls: where they leave room without bounds, the seeds bound it") {
        const Coordinates points{0.5, 0, 0, -0.5, 0.25, 0};
        Options options = test::all_options();
        const auto otherwise = votess::tessellate(points, options).box();
        options.walls = wedge(1e-10);
        options.walls.erase(options.walls.begin() + 2);  // x <= 1
        const auto t = votess::tessellate(points, options);
        CHECK(t.box().lower[0] <= -1);
        CHECK(t.box().upper[0] == otherwise.upper[0]);
        CHECK(t.box().upper[1] == doctest::Approx(1).epsilon(0.01));
        // Two walls differ in one bit only: beyond their line the room has no end.
        options.walls = {{{std::nextafter(1.0, 2), 0, 1}, 1}, {{1, 0, 1}, 1}, {{0, 0, -1}, 1}};
        const auto open = votess::tessellate(points, options);
        CHECK(open.box().lower[0] == otherwise.lower[0]);
        CHECK(open.box().upper[0] == doctest::Approx(2).epsilon(0.01));
        CHECK(open.box().lower[2] == doctest::Approx(-1).epsilon(0.01));
        CHECK(open.box().lower[2] < -1);
        CHECK(open.box().upper[2] == otherwise.upper[2]);
        // A plane between two walls leaves no room.
        options.walls = {{{0, 0, 1}, 0}, {{0, 0, -1}, 0}};
        const auto flat = votess::tessellate(points, options);
        CHECK(flat.stats().box_volume == 0);
        CHECK(flat.stats().empty_cells == 2);
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(flat.box().lower[k] == otherwise.lower[k]);
            CHECK(flat.box().upper[k] == otherwise.upper[k]);
        }
    }

    // The fuzz found it: the oracle's filter lost a vertex to underflow.
    TEST_CASE("walls: a wall as near to the seed as numbers allow") {
        Options options = test::all_options(test::cube(0, 403));
        options.walls = {
            {{1, -1, 0}, std::numeric_limits<double>::denorm_min()}, {{1, 1, -1}, 403.25}, {{1, 1, 0}, 805.5}};
        const Coordinates points{402.75, 402.75, 402.25};
        CHECK(test::row_of(votess::tessellate(points, options), 0) ==
              std::vector<std::int32_t>{-9, -8, -7, -6, -5, -4, -3, -1});
        CHECK(test::check_right(points, options) == "");
    }

    TEST_CASE("walls: spheres, cylinders and cones touch the body, and hold little more") {
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

    TEST_CASE("walls: spheres, cylinders and cones that are refused") {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        const Vector zero{}, up{0, 0, 1};
        const auto refused = [](const auto& make, const char* what) {
            std::string message;
            CHECK(test::error_of([&] { (void)make(); }, &message) == votess::ErrorCode::invalid_argument);
            CAPTURE(message);
            CHECK(test::has(message, what));
        };
        refused([&] { return votess::sphere_walls({0, nan, 0}, 1, 9); }, "center holds nan");
        refused([&] { return votess::sphere_walls(zero, 0, 9); }, "radius 0");
        refused([&] { return votess::sphere_walls(zero, nan, 9); }, "radius nan");
        refused([&] { return votess::sphere_walls(zero, 1, 3); }, "3 faces");
        refused([&] { return votess::sphere_walls(zero, 1, 1000001); }, "1000001 faces");
        refused([&] { return votess::cylinder_walls(zero, zero, 1, 9); }, "axis is 0");
        refused([&] { return votess::cylinder_walls(zero, up, 1, 2); }, "2 faces");
        refused([&] { return votess::cone_walls(zero, up, 1.6, 9); }, "angle 1.6");
        refused([&] { return votess::cone_walls(zero, up, 0, 9); }, "angle 0");
    }

    TEST_CASE("walls: around the convex hull, with every seed inside") {
        test::Random random(41);
        const auto check = [](const Coordinates& points, std::size_t walls) {
            Options options = test::all_options();
            options.list_walls = true;
            options.walls = votess::hull_walls(points);
            CHECK((walls == 0 || options.walls.size() == walls));
            const auto t = votess::tessellate(points, options);
            for (const votess::CellStatus status : t.status()) CHECK(status == votess::CellStatus::certified);
            CHECK(touches_no_box(t));
            CHECK(test::check_right(points, options) == "");
            options.box = t.box();
            CHECK(test::check_against_half_spaces(t, points, options) == "");
        };
        const auto cloud = [&](double center, double size) {
            Coordinates points;
            for (int i = 0; i < 3 * 25; ++i) points.push_back(center + random.uniform(-size, size));
            return points;
        };
        for (const double size : {1.0, 1e-90, 1e90}) check(cloud(0, size), 0);
        check(cloud(1e6, 0.5), 0);
        check(cloud(-3, 1e-9), 0);
        for (const double step : {1.0, 0.1}) {
            CAPTURE(step);
            Coordinates lattice;
            for (int i = 0; i < 27; ++i)
                for (const int k : {i % 3, i / 3 % 3, i / 9}) lattice.push_back(step * k);
            check(lattice, 6);
        }
        check({1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, -1, 0, 0, 0, -1, 0.5, 0.5, 0}, 8);
        // Small whole numbers stay exact.
        const auto corner = votess::hull_walls(Coordinates{0, 0, 0, 3, 0, 0, 0, 3, 0, 0, 0, 3});
        CHECK(std::ranges::count_if(corner, [](const votess::Wall& wall) {
                  return wall.normal == Vector{1, 1, 1} && wall.offset == 3;
              }) == 1);

        Coordinates points = cloud(0, 1);
        const auto walls = votess::hull_walls(points);
        std::ranges::reverse(points);
        for (std::size_t i = 0; i < points.size(); i += 3) std::swap(points[i], points[i + 2]);
        const auto again = votess::hull_walls(points);
        REQUIRE(walls.size() == again.size());
        for (std::size_t w = 0; w < walls.size(); ++w) {
            CHECK(walls[w].normal == again[w].normal);
            CHECK(walls[w].offset == again[w].offset);
        }
    }

    TEST_CASE("walls: convex hulls that are refused") {
        const auto refused = [](const Coordinates& points, const Options& options, const char* what) {
            std::string message;
            CHECK(test::error_of([&] { (void)votess::hull_walls(points, options); }, &message) ==
                  votess::ErrorCode::invalid_argument);
            CAPTURE(message);
            CHECK(test::has(message, what));
        };
        refused({0, 0, 0}, {}, "give at least 4");
        refused({0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 5, 0, 3, 5, 0}, {}, "in one plane");
        refused({0, 0, 0, 1, 2, 3, 2, 4, 6, 3, 6, 9}, {}, "in one plane");
        refused({0, std::numeric_limits<double>::quiet_NaN(), 0}, {}, "point 0: y = nan");
        Options planar;
        planar.planar = true;
        refused({0, 0, 1, 2, 2, 4}, planar, "on one line");
        Options other;
        other.outside = votess::Outside::keep;
        refused({}, other, "outside");
        other = {};
        other.box = test::cube(0, 1);
        refused({}, other, "box are both given");
    }

    TEST_CASE("walls: very many around one seed, each with a face") {
        const std::size_t faces = test::by_size(20'000, 2000);
        Options options;
        options.want = {};
        options.list_walls = true;
        options.walls = votess::sphere_walls({0, 0, 0}, 1, faces);
        const Coordinates points{0.1, 0.05, -0.02};
        CHECK(votess::tessellate(points, options).neighbors(0).size() == faces);
        options.walls = votess::cylinder_walls({0, 0, 0}, {0, 0, 1}, 1, faces);
        options.box = test::cube(-2, 2);
        CHECK(votess::tessellate(points, options).neighbors(0).size() == faces + 2);
    }

    TEST_CASE("walls: all but one meet at the tip of a cone, which the cells of the base do not reach, or do") {
        constexpr std::size_t base = 68;
        test::Random random(9);
        Coordinates points{0, 0, 1};
        for (std::size_t i = 0; i < base; ++i) {
            const double angle = 2 * pi * static_cast<double>(i) / static_cast<double>(base);
            for (const double x : {std::cos(angle), std::sin(angle), 0.0}) points.push_back(x);
        }
        Options options = test::all_options();
        options.list_walls = true;
        options.walls = votess::hull_walls(points);
        for (int k = 0; k < 12; ++k) points.push_back(random.uniform(0, 0.2) + (k % 3 == 2 ? 0.2 : 0.0));
        CHECK(test::check_right(points, options) == "");
        points.erase(points.begin(), points.begin() + 3);
        const auto t = votess::tessellate(points, options);
        CHECK(t.stats().volume_sum == doctest::Approx(t.stats().box_volume).epsilon(1e-12));
    }

    TEST_CASE("walls: thousands around many seeds, in another order, and each of them twice") {
        const std::size_t faces = test::by_size(4000, 400), seeds = test::by_size(2000, 200);
        test::Random random(6);
        Coordinates points;
        while (points.size() < 3 * seeds) {
            const Vector x{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            if (std::hypot(x[0], x[1], x[2]) < 0.95) points.insert(points.end(), x.begin(), x.end());
        }
        Options options = test::all_options(test::cube(-2, 2));
        options.walls = votess::sphere_walls({0, 0, 0}, 1, faces);
        const auto t = votess::tessellate(points, options);
        CHECK(t.stats().volume_sum == doctest::Approx(t.stats().box_volume).epsilon(1e-9));
        // Only each first one has a face.
        for (std::size_t w = 0; w < faces / 2; ++w) std::swap(options.walls[w], options.walls[faces - 1 - w]);
        for (std::size_t w = 0; w < faces; ++w) {
            const auto& [n, d] = options.walls[w];
            options.walls.push_back(w % 2 == 0 ? options.walls[w]
                                               : votess::Wall{{4 * n[0], 4 * n[1], 4 * n[2]}, 4 * d});
        }
        auto turned = test::rows_of(votess::tessellate(points, options));
        for (auto& row : turned) {
            for (std::int32_t& id : row)
                if (id < -6) id = -7 - (static_cast<std::int32_t>(faces) - 1 - (-7 - id));
            std::ranges::sort(row);
        }
        CHECK(turned == test::rows_of(t));
    }

    TEST_CASE("walls: more than are tried in order, through seeds and vertices, with seeds outside") {
        for (std::uint64_t n = 0; n < test::by_size(30, 5); ++n) {
            CAPTURE(n);
            test::Random random(n + 40);
            Options options = test::all_options(test::cube(-2, 2));
            // Normals of few whole numbers: walls meet in vertices, and some are equal or parallel.
            for (int w = 0; w < 60; ++w) {
                Vector normal{};
                while (normal == Vector{})
                    for (double& x : normal) x = static_cast<double>(random.integer(-3, 3));
                const double length = std::hypot(normal[0], normal[1], normal[2]);
                options.walls.push_back(
                    {normal, random.chance(0.5) ? length : static_cast<double>(random.integer(2, 6))});
            }
            options.outside = votess::Outside::drop;
            Coordinates points;
            for (int i = 0; i < 20; ++i)
                for (int k = 0; k < 3; ++k) points.push_back(0.25 * static_cast<double>(random.integer(-5, 5)));
            CHECK(test::check_right(points, options) == "");
        }
    }
}

// triangulate(): polygons are cut without changing their area or their sides. The oracle is integer arithmetic: sides
// that meet, by all pairs; areas, by shoelaces.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>
#include <votess/votess.hpp>

#include "support/random.hpp"
#include "support/text.hpp"

namespace {

using Place = std::array<std::int64_t, 2>;
using Polygon = std::vector<Place>;

std::int64_t doubled(const Place& a, const Place& b, const Place& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

std::int64_t doubled(const Polygon& polygon) {
    std::int64_t sum = 0;
    for (std::size_t k = 2; k < polygon.size(); ++k) sum += doubled(polygon[0], polygon[k - 1], polygon[k]);
    return sum;
}

bool is_between(const Place& a, const Place& b, const Place& x) {
    return doubled(a, b, x) == 0 && std::min(a, b) <= x && x <= std::max(a, b);
}

bool meet(const Place& a, const Place& b, const Place& c, const Place& d) {
    const auto sign = [](std::int64_t x) { return x > 0 ? 1 : x < 0 ? -1 : 0; };
    if (sign(doubled(a, b, c)) * sign(doubled(a, b, d)) < 0 && sign(doubled(c, d, a)) * sign(doubled(c, d, b)) < 0)
        return true;
    return is_between(a, b, c) || is_between(a, b, d) || is_between(c, d, a) || is_between(c, d, b);
}

bool is_simple(const Polygon& p) {
    const std::size_t n = p.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Place &before = p[(i + n - 1) % n], &here = p[i], &after = p[(i + 1) % n];
        if (is_between(before, here, after) || is_between(here, after, before)) return false;  // it turns back
        for (std::size_t j = i + 2; j < n; ++j)
            if ((j + 1) % n != i && meet(here, after, p[j], p[(j + 1) % n])) return false;
    }
    return true;
}

// In space: a plane through three axes in some order, tilted by whole numbers, and run around either way.
struct View {
    std::size_t axis = 2;
    std::int64_t tilt_x = 0, tilt_y = 0;

    [[nodiscard]] std::vector<double> vertices(const Polygon& polygon) const {
        std::vector<double> all;
        for (const Place& p : polygon) {
            std::array<double, 3> x{};
            x[axis] = static_cast<double>(tilt_x * p[0] + tilt_y * p[1]);
            x[(axis + 1) % 3] = static_cast<double>(p[0]);
            x[(axis + 2) % 3] = static_cast<double>(p[1]);
            all.insert(all.end(), x.begin(), x.end());
        }
        return all;
    }
};

View random_view(test::Random& random) {
    const auto tilt = [&] { return random.integer(-2, 2); };
    return {random.below(3), tilt(), tilt()};
}

std::vector<std::int32_t> cut(const Polygon& polygon, const View& view) {
    const std::vector<double> vertices = view.vertices(polygon);
    std::vector<std::int32_t> corners(polygon.size());
    for (std::size_t k = 0; k < corners.size(); ++k) corners[k] = static_cast<std::int32_t>(k);
    const std::array<std::int64_t, 2> offsets{0, static_cast<std::int64_t>(corners.size())};
    return votess::triangulate({vertices, corners, offsets, 0});
}

// Triangles turn as the polygon does, so those of its whole area overlap nowhere.
std::string difference(const Polygon& polygon, const std::vector<std::int32_t>& triangles) {
    const std::int64_t area = doubled(polygon);
    std::int64_t sum = 0;
    std::map<std::pair<std::int32_t, std::int32_t>, int> sides;
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
        const auto corner = [&](std::size_t k) { return triangles[t + k % 3]; };
        const auto at = [&](std::size_t k) { return polygon[static_cast<std::size_t>(corner(k))]; };
        const std::int64_t part = doubled(at(0), at(1), at(2));
        if (part == 0 || (part > 0) != (area > 0)) return test::text("triangle ", t / 3, " has the area ", part);
        sum += part;
        for (std::size_t k = 0; k < 3; ++k) {
            ++sides[{corner(k), corner(k + 1)}];
            --sides[{corner(k + 1), corner(k)}];
        }
    }
    if (sum != area) return test::text("areas sum to ", sum, " of ", area);
    const auto n = static_cast<std::int32_t>(polygon.size());
    for (std::int32_t k = 0; k < n; ++k) --sides[{k, (k + 1) % n}], ++sides[{(k + 1) % n, k}];
    for (const auto& [side, count] : sides)
        if (count != 0) return test::text("side ", side.first, " to ", side.second);
    return "";
}

Polygon star(test::Random& random, int corners) {
    Polygon polygon;
    for (int k = 0; k < corners; ++k) {
        const double angle = 2 * std::numbers::pi * k / corners, r = random.uniform(1e3, 1e5);
        polygon.push_back({std::lround(r * std::cos(angle)), std::lround(r * std::sin(angle))});
    }
    return polygon;
}

Polygon comb(test::Random& random, int teeth) {
    Polygon polygon{{2 * teeth, -5}, {0, -5}};
    for (int k = 0; k < teeth; ++k) {
        polygon.push_back({2 * k, random.integer(0, 49)});
        polygon.push_back({2 * k + 1, random.integer(-3, -1)});
    }
    return polygon;
}

Polygon spiral(int turns) {
    Polygon polygon, back;
    for (int k = 0; k < 24 * turns; ++k) {
        const double angle = 2 * std::numbers::pi * k / 24, r = 1000 + 100 * k;
        const auto at = [&](double radius) {
            return Place{std::lround(radius * std::cos(angle)), std::lround(radius * std::sin(angle))};
        };
        polygon.push_back(at(r));
        back.push_back(at(r + 900));
    }
    polygon.insert(polygon.end(), back.rbegin(), back.rend());
    return polygon;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("triangulate: small polygons on a grid, simple or not") {
        test::Random random(60);
        int simple = 0, refused = 0;
        for (int set = 0; set < 40'000; ++set) {
            const std::int64_t width = random.integer(2, 8);
            Polygon polygon(4 + random.below(8));
            for (Place& p : polygon) p = {random.integer(0, width), random.integer(0, width)};
            bool repeats = false, on_line = true;
            for (std::size_t k = 0; k < polygon.size(); ++k) {
                repeats |= polygon[k] == polygon[(k + 1) % polygon.size()];
                for (const Place& p : polygon) on_line &= doubled(polygon[0], polygon[k], p) == 0;
            }
            if (repeats || on_line) continue;
            const View view = random_view(random);
            CAPTURE(set);
            if (is_simple(polygon)) {
                ++simple;
                REQUIRE(difference(polygon, cut(polygon, view)) == "");
            } else {
                ++refused;
                REQUIRE_THROWS_WITH_AS(cut(polygon, view), doctest::Contains("not simple"), votess::Error);
            }
        }
        CHECK(simple > 2'000);
        CHECK(refused > 20'000);
    }

    TEST_CASE("triangulate: stars, combs and spirals") {
        test::Random random(61);
        for (int set = 0; set < 60; ++set) {
            Polygon polygon = set % 3 == 0   ? star(random, 5 + 4 * set)
                              : set % 3 == 1 ? comb(random, 2 + 3 * set)
                                             : spiral(1 + set / 3);
            if (set % 2 == 1) polygon = {polygon.rbegin(), polygon.rend()};
            CAPTURE(set);
            REQUIRE(is_simple(polygon));
            CHECK(difference(polygon, cut(polygon, random_view(random))) == "");
        }
    }

    TEST_CASE("triangulate: a convex polygon is a fan, corners at one place are kept") {
        const View flat;
        CHECK(cut({{0, 0}, {4, 0}, {6, 3}, {3, 5}}, flat) == std::vector<std::int32_t>{0, 1, 2, 0, 2, 3});
        const std::vector<double> vertices{0, 0, 0, 4, 0, 0, 4, 0, 0, 4, 4, 0, 0, 4, 0, 0, 0, 0};
        const std::vector<std::int32_t> corners{0, 1, 2, 3, 4, 5, 0, 1, 1, 3};
        const std::vector<std::int64_t> offsets{0, 6, 10};
        std::map<std::pair<std::int32_t, std::int32_t>, int> sides;
        const std::vector<std::int32_t> triangles = votess::triangulate({vertices, corners, offsets, 0});
        for (std::size_t i = 0; i < triangles.size(); i += 3)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto from = triangles[i + k], to = triangles[i + (k + 1) % 3];
                ++(from < to ? sides[{from, to}] : sides[{to, from}]);
            }
        const std::vector<std::pair<std::int32_t, std::int32_t>> of_both{{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5},
                                                                         {0, 5}, {0, 1}, {1, 3}, {0, 3}};
        for (const auto& side : of_both) ++sides[side];
        for (const auto& [side, count] : sides) CHECK(count % 2 == 0);
    }

    TEST_CASE("triangulate: refusals name the polygon") {
        const std::vector<double> vertices{0, 0, 0, 1,    0, 0, 1,    1, 0.1, 0,           1,
                                           0, 1, 1, 1e-6, 1, 1, 1e-3, 1, 1,   std::nan("")};
        const auto refused = [&](const std::vector<std::int32_t>& corners, const std::string& says) {
            std::vector<double> finite(vertices.begin(), vertices.end() - 3);
            const std::array<std::int64_t, 3> offsets{0, 3, static_cast<std::int64_t>(3 + corners.size())};
            std::vector<std::int32_t> all{0, 1, 3};
            all.insert(all.end(), corners.begin(), corners.end());
            CAPTURE(says);
            CHECK_THROWS_WITH_AS((void)votess::triangulate({finite, all, offsets, 1}), doctest::Contains(says.c_str()),
                                 votess::Error);
        };
        refused({0, 1, 2, 3}, "face 2 is not flat: its vertex ");
        refused({0, 1, 5, 3}, "face 2 is not flat: its vertex ");
        refused({0, 4, 1, 3}, "face 2 is not simple: its sides from vertex ");
        refused({0, 1, 9, 3}, "face 2 names vertex 10, but there are 6");
        refused({0, 1}, "face 2 has 2 corners");
        const std::vector<std::int32_t> corners{0, 1, 4, 3};
        const std::array<std::int64_t, 2> offsets{0, 4}, falling{4, 0};
        const std::span<const double> finite = std::span(vertices).first(18);
        CHECK(votess::triangulate({finite, corners, offsets, 0}).size() == 6);  // flat to rounding
        CHECK_THROWS_WITH_AS((void)votess::triangulate({finite, corners, falling, 0}),
                             doctest::Contains("offsets hold 4 and 0"), votess::Error);
        CHECK_THROWS_WITH_AS((void)votess::triangulate({vertices, corners, offsets, 1}),
                             doctest::Contains("vertex 7: z = nan is not finite"), votess::Error);
    }
}

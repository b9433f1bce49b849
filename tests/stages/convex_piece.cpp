// Convex pieces and polygons: both sides of a cut add up, in general places and where rounding decides what lies on the
// plane.
#include "core/convex_piece.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/convex_polygon.hpp"
#include "support/random.hpp"

using votess::ConvexPiece;

namespace {

using Vector = ConvexPiece::Vector;

Vector random_direction(test::Random& random) {
    return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

ConvexPiece box_of(const Vector& lower, const Vector& upper) {
    ConvexPiece box;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        std::array<Vector, 4> low{lower, lower, lower, lower};
        low[1][i] = low[2][i] = upper[i];
        low[2][j] = low[3][j] = upper[j];
        std::array<Vector, 4> high = low;
        for (Vector& corner : high) corner[k] = upper[k];
        std::ranges::reverse(low);
        box.add_polygon(low);
        box.add_polygon(high);
    }
    return box;
}

// A box with its corners cut off at random.
ConvexPiece random_piece(test::Random& random) {
    ConvexPiece piece = box_of({0, 0, 0}, {1, 2, 0.5});
    for (int i = 0; i < 12; ++i) {
        const Vector n = random_direction(random);
        piece.cut(n, n[0] * 0.5 + n[1] + n[2] * 0.25 + random.uniform(0.2, 0.8));
    }
    return piece;
}

ConvexPiece copy_of(const ConvexPiece& piece) {
    ConvexPiece copy;
    copy.assign(piece);
    return copy;
}

void check_sum(const ConvexPiece::Measure& whole, const ConvexPiece& a, const ConvexPiece& b) {
    const auto one = a.measure(), other = b.measure();
    CHECK(std::abs(one.volume + other.volume - whole.volume) < 1e-14);
    for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(one.moment[k] + other.moment[k] - whole.moment[k]) < 1e-14);
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("convex piece: a box and its parts have their volumes and centers") {
        ConvexPiece box = box_of({1, 2, 3}, {2, 4, 6}), below;
        CHECK(box.volume() == doctest::Approx(6).epsilon(1e-15));
        CHECK(box.extent({0, 1, 0}) == std::pair(2.0, 4.0));
        box.split({0, 0, 1}, 4, below);
        CHECK(below.volume() == doctest::Approx(2).epsilon(1e-15));
        CHECK(below.measure().moment[2] == doctest::Approx(7).epsilon(1e-15));
        CHECK(box.measure().moment[2] == doctest::Approx(20).epsilon(1e-15));
        // The corner of a box beyond x + y + z = 1 is a tetrahedron.
        ConvexPiece corner = box_of({0, 0, 0}, {1, 1, 1});
        CHECK(corner.cut({1, 1, 1}, 1));
        CHECK(corner.volume() == doctest::Approx(1.0 / 6).epsilon(1e-15));
        CHECK(corner.polygons() == 4);
        CHECK(corner.measure().moment[0] == doctest::Approx(1.0 / 24).epsilon(1e-15));
        CHECK_FALSE(corner.cut({1, 0, 0}, -1));
        CHECK(corner.empty());
    }

    TEST_CASE("convex piece: both sides of a plane add up") {
        test::Random random(1);
        for (int set = 0; set < 500; ++set) {
            CAPTURE(set);
            const ConvexPiece piece = random_piece(random);
            const auto whole = piece.measure();
            const Vector n = random_direction(random);
            const double h = n[0] * 0.5 + n[1] + n[2] * 0.25 + random.uniform(-0.5, 0.5);
            ConvexPiece one = copy_of(piece), other = copy_of(piece);
            one.cut(n, h);
            other.cut({-n[0], -n[1], -n[2]}, -h);
            check_sum(whole, one, other);
            ConvexPiece above = copy_of(piece), below;
            above.split({0, 1, 0}, random.uniform(0, 2), below);
            check_sum(whole, above, below);
        }
    }

    TEST_CASE("convex piece: planes that lie in its faces up to rounding") {
        // Bodies whose corners should lie in the plane x = 1 or 0, and lie a rounding beside it.
        test::Random random(2);
        const auto noise = [&] { return 1e-16 * static_cast<double>(random.integer(-2, 2)); };
        for (int set = 0; set < 2000; ++set) {
            CAPTURE(set);
            std::array<Vector, 8> corner{};
            for (std::size_t c = 0; c < 8; ++c)
                for (std::size_t k = 0; k < 3; ++k) corner[c][k] = static_cast<double>(c >> k & 1) + noise();
            ConvexPiece piece, below;
            constexpr int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
            for (const auto& face : faces) {
                std::array<Vector, 4> polygon;
                for (std::size_t c = 0; c < 4; ++c) polygon[c] = corner[static_cast<std::size_t>(face[c])];
                piece.add_polygon(polygon);
            }
            // Apart from where the measure begins.
            const auto whole = piece.measure();
            CHECK(whole.volume == doctest::Approx(1).epsilon(1e-14));
            for (const Vector& n : {Vector{1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
                for (const double h : {0.0, 1.0}) {
                    ConvexPiece above = copy_of(piece);
                    above.split(n, h, below);
                    check_sum(whole, above, below);
                    CHECK(std::abs((h > 0 ? above : below).volume()) < 1e-14);
                }
        }
    }

    TEST_CASE("convex polygon: parts add up, with any signs of corners near the plane") {
        test::Random random(11);
        const auto area_of = [](const votess::ConvexPolygon& polygon) {
            double area = 0;
            for (std::size_t c = 1; c + 1 < polygon.corners.size(); ++c) {
                const Vector &o = polygon.corners[0], &a = polygon.corners[c], &b = polygon.corners[c + 1];
                area += ((a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])) / 2;
            }
            return area;
        };
        for (int set = 0; set < 3000; ++set) {
            votess::ConvexPolygon polygon, below;
            const int count = 3 + set % 6;
            for (int c = 0; c < count; ++c) {
                const double angle = 2 * 3.141592653589793 * (c + random.uniform(0, 0.9)) / count;
                const double height = 1e-16 * std::round(random.uniform(-1.5, 1.5));  // each sign, and 0
                polygon.corners.push_back({std::cos(angle), std::sin(angle), height});
            }
            const double whole = area_of(polygon);
            if (set % 2 == 0) polygon.split({random.uniform(-1, 1), random.uniform(-1, 1), 0}, 0.1, below);
            const double beside = area_of(below);
            polygon.split({0, 0, 1}, 0, below);
            CHECK(std::abs(area_of(polygon) + area_of(below) + (set % 2 == 0 ? beside : 0) - whole) < 1e-14);
        }
    }
}

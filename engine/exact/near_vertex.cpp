// The vertex of three planes by iterative refinement (Wilkinson 1963; Higham, Accuracy and Stability of Numerical
// Algorithms, chapter 12): x is corrected by the solution for the residual h - N.x, which is summed in double-double
// arithmetic.
//
// Error, with u = 2^-53 and e = 62 u |Na||Nb||Nc| / |det|. Cramer's rule is wrong by e times the length of its solution
// (cell.hpp). So each step multiplies the error by e and adds u |X| for the rounding of x. Residuals are wrong by at
// most 600 u^2 |N||X|, which moves the vertex by less than 30 u e |X| < u |X| / 8. Steps end when the error is below
// u |X| / 4 beside the last rounding.
#include <cmath>
#include <optional>

#include "core/vector3.hpp"
#include "exact/integer/rows.hpp"
#include "exact/predicate.hpp"

namespace votess::exact {
namespace {

// N.X = h
struct SharpPlane {
    std::array<DoubleDouble, 3> n{};
    DoubleDouble h;
};

// Returns nothing where two doubles do not hold N, or h to 500 u^2.
std::optional<SharpPlane> sharp_plane(const Point& p, const Plane& plane) {
    constexpr double worst_cancellation = 1.0 / 16;
    SharpPlane sharp;
    if (plane.kind == Plane::Kind::cell_wall) return std::nullopt;
    if (plane.kind == Plane::Kind::wall) {
        sharp.h.high = plane.wall;
        double size = std::abs(plane.wall);
        for (int k = 0; k < 3; ++k) {
            const DoubleDouble product = two_product(plane.seed[k], -p[k]);
            sharp.n[k].high = plane.seed[k];
            sharp.h = sharp.h + product;
            size += std::abs(product.high);
        }
        if (!(std::abs(sharp.h.high) > worst_cancellation * size)) return std::nullopt;
        return sharp;
    }
    if (!plane.is_bisector()) {
        const auto [sign, distance] = wall_difference(p, plane);
        sharp.n[plane.axis].high = sign;
        sharp.h = distance;
        return sharp;
    }
    const Differences difference = differences(p, plane);
    if (!difference.exact) return std::nullopt;
    sharp.n = difference.x;
    DoubleDouble square = plane.power;
    for (const DoubleDouble& x : sharp.n) square = square + x * x;
    if (!(std::abs(square.high) > worst_cancellation * std::abs(plane.power.high))) return std::nullopt;
    sharp.h = {0.5 * square.high, 0.5 * square.low};
    return sharp;
}

double residual(const SharpPlane& plane, const Point& x) {
    DoubleDouble sum = plane.h;
    for (int k = 0; k < 3; ++k) sum = sum + plane.n[k] * DoubleDouble{-x[k], 0};
    return sum.high;
}

std::optional<Point> refine(const Point& p, const std::array<const Plane*, 3>& planes) {
    constexpr double unit = 0x1p-53, largest_factor = 0x1p-8;
    constexpr double smallest_square = 0x1p-200, largest_square = 0x1p200;  // no product leaves the range
    std::array<SharpPlane, 3> sharp;
    std::array<Point, 3> n;
    double squares = 1;
    for (int i = 0; i < 3; ++i) {
        const std::optional<SharpPlane> found = sharp_plane(p, *planes[i]);
        if (!found) return std::nullopt;
        sharp[i] = *found;
        for (int k = 0; k < 3; ++k) n[i][k] = sharp[i].n[k].high;
        const double square = dot(n[i], n[i]);
        if (!(square > smallest_square && square < largest_square && std::abs(sharp[i].h.high) < largest_square))
            return std::nullopt;
        squares *= square;
    }
    const std::array<Point, 3> across{cross(n[1], n[2]), cross(n[2], n[0]), cross(n[0], n[1])};
    const double determinant = dot(n[0], across[0]);
    const double factor = 62 * unit * std::sqrt(squares) / std::abs(determinant);
    if (!(factor < largest_factor)) return std::nullopt;
    Point x{};
    for (double error = 4; error > unit; error *= factor) {  // four times that of x before its rounding, in |X|
        std::array<double, 3> rest;
        for (int i = 0; i < 3; ++i) rest[i] = residual(sharp[i], x) / determinant;
        for (int k = 0; k < 3; ++k) x[k] += rest[0] * across[0][k] + rest[1] * across[1][k] + rest[2] * across[2][k];
    }
    return x;
}

}  // namespace

Point near_vertex(const Point& p, const Plane& a, const Plane& b, const Plane& c) {
    if (const auto x = refine(p, {&a, &b, &c})) return *x;
    // In double it would be rounded three times.
    const auto [x, y, z] = vertex_position<Quad>(p, a, b, c);
    return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

}  // namespace votess::exact

// Bounds. Each plane is scaled by a power of two, so that the length of its normal is from 1 to A = 2. So far planes do
// not blur near ones. A normal is then wrong by at most e = 4 u + 2 slack, u = 2^-53, with the slack times the largest
// scale. The numbers d = n.n / 2 + (w - w') / 2 have terms of at most D, where D >= |n| / 2 for all normals before they
// are scaled. They are wrong by 2 D e + 4 u D. Products of two normals are wrong by 2 A e + 6 u A^2. Hence the
// determinant W of three normals is wrong by 3 A^2 e + 10 u A^3, and the corner X, the sum of d b x c, by 18 A D e + 42
// u D A^2. With |X| <= 3 D A^2 and |W| <= A^3, n.X - d W is wrong by
//     28 D A^2 e + 72 u D A^3.
// The factors below are larger, for what is of second order. A wall has a normal of length 1 and d = its distance, so
// that it fits among the others: e is larger by the error of the distance, divided by 2 D. Distances keep some digits.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "follow/sign_test.hpp"

namespace votess::cpu {

// Isa: anything, one for each instruction set for which a file compiles this.
template <class Isa>
class SignKernel {
    using Wide __attribute__((vector_size(32), may_alias)) = double;

public:
    static bool test(const SignFrame& frame, std::size_t seed, const KeptCell& cell, SignTest& out);

private:
    [[gnu::always_inline]] static void cross(const Wide& a, const Wide& b, Wide& out) {
        const Wide turned_a = __builtin_shufflevector(a, a, 1, 2, 0, 3),
                   turned_b = __builtin_shufflevector(b, b, 1, 2, 0, 3);
        const Wide c = a * turned_b - turned_a * b;
        out = __builtin_shufflevector(c, c, 1, 2, 0, 3);
    }
    // Returns the power of two that brings the root of a normal number to 1 or more, and below 2.
    [[gnu::always_inline]] static double inverse_power(double square) {
        constexpr std::int64_t bias = 1023;
        constexpr int mantissa = 52;
        const std::int64_t exponent = (std::bit_cast<std::int64_t>(square) >> mantissa) - bias;
        return std::bit_cast<double>((bias - (exponent >> 1)) << mantissa);
    }
};

template <class Isa>
bool SignKernel<Isa>::test(const SignFrame& frame, std::size_t seed, const KeptCell& cell, SignTest& out) {
    constexpr double u = 0x1p-53, least = 0x1p-160, most = 0x1p160;  // fifth powers neither underflow nor overflow
    constexpr double length = 2, square = length * length, max_error = 0x1p-10;
    constexpr double least_errors = 0x1p14;  // of a distance from a wall, so that CellPlane::reliable holds
    const KeptCell::Head& head = cell.head();
    out.tested = false;
    const std::int32_t* const ids = cell.ids().data();
    const std::uint8_t *plane = cell.planes().data(), *const last_plane = plane + head.planes;
    if (plane == last_plane) return out.tested = true;
    const SeedPlace& own = frame.places[seed];
    const Wide at{own.x[0], own.x[1], own.x[2], 0};
    Wide *const planes = reinterpret_cast<Wide*>(out.plane), *const corners = reinterpret_cast<Wide*>(out.corner);
    double shortest = most * most, size = 0, largest_scale = 0, wall_error = 0;
    for (; plane != last_plane && ids[*plane] < 0; ++plane) {  // walls come first
        const int f = *plane;
        const SignWall& wall = frame.walls[-1 - ids[f]];
        const double distance = wall.offset - (wall.n[0] * own.x[0] + wall.n[1] * own.x[1] + wall.n[2] * own.x[2]);
        if (!(distance > least_errors * frame.wall_error)) return false;
        planes[f] = Wide{wall.n[0], wall.n[1], wall.n[2], -distance};
        size = std::max(size, distance);
        wall_error = frame.wall_error;
        out.scale[f] = 1;
    }
    for (; plane != last_plane; ++plane) {
        const int f = *plane;
        const SeedPlace& other = frame.places[ids[f]];
        Wide n = Wide{other.x[0], other.x[1], other.x[2], 0} - at;
        if (head.shifted) {
            const exact::Shift shift = cell.shift(static_cast<std::size_t>(f));
            for (int j = 0; j < 3; ++j)
                if (shift[static_cast<std::size_t>(j)] != 0) {
                    const double by = shift[static_cast<std::size_t>(j)];
                    if (std::abs(by) > 2) return false;
                    n += by * Wide{frame.vector[j][0], frame.vector[j][1], frame.vector[j][2], 0};
                }
        }
        const Wide squares = n * n;
        const double length2 = squares[0] + squares[1] + squares[2];
        shortest = std::min(shortest, length2);
        double d = 0.5 * length2, terms = d;
        if (frame.weighted) {
            const double heavier = 0.5 * (own.weight - other.weight);
            d += heavier;
            terms += std::abs(heavier);
        }
        n[3] = -d;
        const double scale = inverse_power(length2);
        out.scale[f] = scale;
        largest_scale = std::max(largest_scale, scale);
        size = std::max(size, terms * scale);
        planes[f] = scale * n;
    }
    size *= 1 + 8 * u;
    const double slack = frame.slack * largest_scale, error = 2 * u * length + 2 * slack + wall_error / size;
    if (!(shortest > least * least && size > least && size < most && error < max_error)) return false;
    const double w_bound = square * (4 * error + 14 * u * length);
    const double x_bound = length * size * (20 * error + 48 * u * length);
    const double bound = size * square * (32 * error + 90 * u * length);
    out.test_bound = bound;
    const double reach2 = frame.reach_squared;
    int wrong = 0;
    const KeptCell::Corner* const corner = cell.corners().data();
    for (int v = 0; v < head.used; ++v) {
        const Wide a = planes[corner[v][0]], b = planes[corner[v][1]], c = planes[corner[v][2]];
        Wide ab, bc, ca;
        cross(a, b, ab);
        cross(b, c, bc);
        cross(c, a, ca);
        Wide x = -(a[3] * bc + b[3] * ca + c[3] * ab);
        const Wide products = a * bc;
        const double w = products[0] + products[1] + products[2];
        x[3] = w;
        corners[v] = x;
        double margin = w - w_bound;
        if (reach2 < most) {
            const double far2 = x[0] * x[0] + x[1] * x[1] + x[2] * x[2], reach_w2 = reach2 * margin * margin;
            if (!(4 * (far2 + x_bound * x_bound) < reach_w2)) {  // mostly not, and a root takes longer
                const double far = std::sqrt(far2) * (1 + 8 * u) + x_bound;
                if (!(far * far < reach_w2)) margin = -1;
            }
        }
        out.corner_margin[v] = margin;
        wrong += !(margin > 0);
    }
    const KeptCell::Test* const tests = cell.tests().data();
    for (int t = 0; t < head.tests; ++t) {
        const Wide value = planes[tests[t].plane] * corners[tests[t].corner];
        const double margin = -((value[0] + value[1]) + (value[2] + value[3])) - bound;
        out.test_margin[t] = margin;
        wrong += !(margin > 0);
    }
    out.tested = true;
    return wrong == 0;
}

}  // namespace votess::cpu

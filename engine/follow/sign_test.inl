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
    using Bits __attribute__((vector_size(32))) = std::uint64_t;
    struct Four {  // planes or corners, by coordinate
        Wide x, y, z, w;
    };
    // at(k) is the k-th row.
    template <class At>
    [[gnu::always_inline]] static void transpose(At at, Four& out) {
        const Wide &a = at(0), &b = at(1), &c = at(2), &d = at(3);
        const Wide xz01 = __builtin_shufflevector(a, b, 0, 4, 2, 6), yw01 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
        const Wide xz23 = __builtin_shufflevector(c, d, 0, 4, 2, 6), yw23 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
        out.x = __builtin_shufflevector(xz01, xz23, 0, 1, 4, 5);
        out.y = __builtin_shufflevector(yw01, yw23, 0, 1, 4, 5);
        out.z = __builtin_shufflevector(xz01, xz23, 2, 3, 6, 7);
        out.w = __builtin_shufflevector(yw01, yw23, 2, 3, 6, 7);
    }
    [[gnu::always_inline]] static void transpose(const Four& rows, Four& out) {
        const Wide* const row[4] = {&rows.x, &rows.y, &rows.z, &rows.w};
        transpose([&](int k) -> const Wide& { return *row[k]; }, out);
    }
    [[gnu::always_inline]] static void cross(const Four& a, const Four& b, Four& out) {
        out.x = a.y * b.z - a.z * b.y;
        out.y = a.z * b.x - a.x * b.z;
        out.z = a.x * b.y - a.y * b.x;
    }
    // Returns the powers of two that bring the roots of normal numbers to 1 or more, and below 2.
    [[gnu::always_inline]] static void inverse_powers(const Wide& squares, Wide& out) {
        constexpr std::uint64_t bias = 1023, half = 512;
        constexpr int mantissa = 52;
        const Bits exponent = reinterpret_cast<Bits>(squares) >> mantissa;
        out = reinterpret_cast<Wide>((bias + half - ((exponent + 1) >> 1)) << mantissa);
    }
    template <class Mask>
    [[gnu::always_inline]] static bool all(const Mask& mask) {
        return (mask[0] & mask[1] & mask[2] & mask[3]) != 0;
    }
    [[gnu::always_inline]] static double largest(const Wide& v) {
        return std::max(std::max(v[0], v[1]), std::max(v[2], v[3]));
    }
    [[gnu::always_inline]] static double smallest(const Wide& v) {
        return std::min(std::min(v[0], v[1]), std::min(v[2], v[3]));
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
    const Wide at{own.x[0], own.x[1], own.x[2], own.weight};
    Wide *const planes = reinterpret_cast<Wide*>(out.plane), *const corners = reinterpret_cast<Wide*>(out.corner);
    double size = 0, wall_error = 0;
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
    Wide shortest2 = Wide{} + most * most, sizes{}, scales{};
    for (; plane < last_plane; plane += 4) {
        // Four at a time; the last one fills up.
        const std::uint8_t* const last = last_plane - 1;
        const int four[4] = {plane[0], *std::min(plane + 1, last), *std::min(plane + 2, last),
                             *std::min(plane + 3, last)};
        Wide way[4];  // and how much heavier the other is
        for (int k = 0; k < 4; ++k) way[k] = reinterpret_cast<const Wide&>(frame.places[ids[four[k]]]) - at;
        if (head.shifted)
            for (int k = 0; k < 4; ++k) {
                const KeptCell::NearShift shift = cell.near_shift(static_cast<std::size_t>(four[k]));
                for (std::size_t j = 0; j < 3; ++j) {
                    const double by = shift[j];
                    const auto& vector = frame.vector[j];
                    if (shift[j] != 0) way[k] += by * Wide{vector[0], vector[1], vector[2], 0};
                }
            }
        Four n;
        transpose([&](int k) -> const Wide& { return way[k]; }, n);
        const Wide length2 = n.x * n.x + n.y * n.y + n.z * n.z, half = 0.5 * length2, lighter = -0.5 * n.w;
        Wide scale;
        inverse_powers(length2, scale);
        const Wide terms = (half + (lighter < 0 ? -lighter : lighter)) * scale;
        shortest2 = length2 < shortest2 ? length2 : shortest2;
        scales = scale > scales ? scale : scales;
        sizes = terms > sizes ? terms : sizes;
        const Four scaled{scale * n.x, scale * n.y, scale * n.z, -scale * (half + lighter)};
        Four rows;
        transpose(scaled, rows);
        planes[four[0]] = rows.x, planes[four[1]] = rows.y, planes[four[2]] = rows.z, planes[four[3]] = rows.w;
        for (int k = 0; k < 4; ++k) out.scale[four[k]] = scale[k];
    }
    const double shortest = smallest(shortest2), largest_scale = largest(scales);
    size = std::max(size, largest(sizes));
    size *= 1 + 8 * u;
    const double slack = frame.slack * largest_scale, error = 2 * u * length + 2 * slack + wall_error / size;
    if (!(shortest > least * least && size > least && size < most && error < max_error)) return false;
    const double w_bound = square * (4 * error + 14 * u * length);
    const double x_bound = length * size * (20 * error + 48 * u * length);
    const double bound = size * square * (32 * error + 90 * u * length);
    out.test_bound = bound;
    const double reach2 = frame.reach_squared;
    auto right = Wide{} == 0;
    const KeptCell::Corner* const corner = cell.corners().data();
    for (int v = 0; v < head.used; v += 4) {
        const auto of = [&](int k) -> const KeptCell::Corner& { return corner[std::min(v + k, head.used - 1)]; };
        Four a, b, c, ab, bc, ca;
        transpose([&](int k) -> const Wide& { return planes[of(k)[0]]; }, a);
        transpose([&](int k) -> const Wide& { return planes[of(k)[1]]; }, b);
        transpose([&](int k) -> const Wide& { return planes[of(k)[2]]; }, c);
        cross(a, b, ab);
        cross(b, c, bc);
        cross(c, a, ca);
        const Four x{-(a.w * bc.x + b.w * ca.x + c.w * ab.x), -(a.w * bc.y + b.w * ca.y + c.w * ab.y),
                     -(a.w * bc.z + b.w * ca.z + c.w * ab.z), a.x * bc.x + a.y * bc.y + a.z * bc.z};
        Wide margin = x.w - w_bound;
        if (reach2 < most) {
            const Wide far2 = x.x * x.x + x.y * x.y + x.z * x.z, reach_w2 = reach2 * margin * margin;
            if (!all(4 * (far2 + x_bound * x_bound) < reach_w2))  // mostly not, and a root takes longer
                for (int k = 0; k < 4; ++k) {
                    const double far = std::sqrt(far2[k]) * (1 + 8 * u) + x_bound;
                    if (!(far * far < reach_w2[k])) margin[k] = -1;
                }
        }
        reinterpret_cast<Wide&>(out.corner_margin[v]) = margin;
        right &= margin > 0;
        Four rows;
        transpose(x, rows);
        corners[v] = rows.x, corners[v + 1] = rows.y, corners[v + 2] = rows.z, corners[v + 3] = rows.w;
    }
    const KeptCell::Test* const tests = cell.tests().data();
    for (int t = 0; t < head.tests; t += 4) {
        Wide product[4];
        for (int k = 0; k < 4; ++k) {
            const auto [v, f] = tests[std::min(t + k, head.tests - 1)];
            product[k] = planes[f] * corners[v];
        }
        Four sum;
        transpose([&](int k) -> const Wide& { return product[k]; }, sum);
        const Wide margin = -((sum.x + sum.y) + (sum.z + sum.w)) - bound;
        reinterpret_cast<Wide&>(out.test_margin[t]) = margin;
        right &= margin > 0;
    }
    out.tested = true;
    return all(right);
}

}  // namespace votess::cpu

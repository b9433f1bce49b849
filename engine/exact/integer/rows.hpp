// Planes as rows of integers, for the exact decisions. Float64 coordinates are integers times a power of two. The
// lowest power in a set of them, the quantum, is their unit; the width follows from the highest.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/vector3.hpp"
#include "exact/double_double.hpp"
#include "exact/integer/wide_int.hpp"
#include "exact/predicate.hpp"

namespace votess::exact {

// Exponents of the lowest and one above the highest set bit over a set of doubles.
struct BitRange {
    int low = std::numeric_limits<int>::max();
    int high = std::numeric_limits<int>::min();
    int normal_bits = 0;  // of walls that have units of their own

    void add(double x) {
        const auto bits = std::bit_cast<std::uint64_t>(x);
        const auto fraction = bits & ((1ull << 52) - 1);
        const int biased = static_cast<int>((bits >> 52) & 0x7ff);
        if (biased == 0 && fraction == 0) return;
        const std::uint64_t mantissa = biased == 0 ? fraction : fraction | (1ull << 52);
        const int exponent = (biased == 0 ? 1 : biased) - 1075;
        low = std::min(low, exponent + std::countr_zero(mantissa));
        high = std::max(high, exponent + 64 - std::countl_zero(mantissa));
    }
    void add(const Point& p) {
        for (double x : p) add(x);
    }
    void add(const Plane& plane) {
        if (plane.kind == Plane::Kind::cell_wall) {
            normal_bits = std::max(normal_bits, of_vectors_in(plane).product_bits());
            return add_image(plane);
        }
        if (!plane.is_bisector()) return add(plane.wall);
        add(plane.seed);
        if (plane.lattice != nullptr) add_image(plane);
        if (plane.has_power()) {  // in units squared
            BitRange power;
            power.add(plane.power.high);
            power.add(plane.power.low);
            low = std::min(low, power.low >> 1);
            high = std::max(high, ((power.high + 1) >> 1) + 1);
        }
    }
    void add_image(const Plane& plane) {
        BitRange sum;
        sum.add(plane.seed);
        for (int j = 0; j < 3; ++j) {
            const auto times = static_cast<std::uint32_t>(std::abs(plane.shift[j]));
            if (times == 0) continue;
            BitRange product;
            for (const DoubleDouble& x : plane.lattice->vector[j]) {
                product.add(x.high);
                product.add(x.low);
            }
            if (product.high < product.low) continue;
            sum.low = std::min(sum.low, product.low);
            sum.high = std::max(sum.high, product.high + static_cast<int>(std::bit_width(times)));
        }
        low = std::min(low, sum.low);
        high = std::max(high, sum.high + 3);  // of up to seven terms
    }
    static BitRange of_vectors_in(const Plane& wall) {
        BitRange range;
        for (int j = 1; j <= 2; ++j)
            for (const DoubleDouble& x : wall.lattice->vector[(wall.axis + j) % 3]) range.add(x.high);
        return range;
    }
    [[nodiscard]] int product_bits() const { return 2 * span() + 1; }  // of a difference of two products
    [[nodiscard]] int span() const { return std::max(normal_bits, high > low ? high - low : 0); }
    [[nodiscard]] int quantum() const { return high > low ? low : 0; }
};

// A double as mantissa * 2^exponent; of at most 53 bits.
struct Mantissa {
    std::int64_t mantissa;
    int exponent;
};

inline Mantissa mantissa_of(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const auto fraction = static_cast<std::int64_t>(bits & ((1ull << 52) - 1));
    const int biased = static_cast<int>((bits >> 52) & 0x7ff);
    const std::int64_t size = biased == 0 ? fraction : fraction | (std::int64_t{1} << 52);
    return {(bits >> 63) != 0 ? -size : size, (biased == 0 ? 1 : biased) - 1075};
}

// Returns x / 2^quantum as an integer. Exact when the quantum divides x and W holds it.
template <int W>
WideInt<W> to_wide(double x, int quantum) {
    const auto [mantissa, exponent] = mantissa_of(x);
    const int shift = exponent - quantum;
    if (shift >= 0) return shift_left(from_int128<W>(mantissa), shift);
    return from_int128<W>(shift <= -64 ? 0 : mantissa >> -shift);
}

inline Int128 to_int128(double x, int quantum) {
    const auto [mantissa, exponent] = mantissa_of(x);
    const int shift = exponent - quantum;
    if (shift >= 0) return shift < 127 ? static_cast<Int128>(mantissa) << shift : 0;
    return shift > -64 ? mantissa >> -shift : 0;
}

// A plane in integer units: 2 N.X <= S.
template <class N, class S>
struct Row {
    std::array<N, 3> n;
    S s;
};

// N of a bisector, or the unit normal and distance of a wall of the box.
struct Difference {
    std::array<Int128, 3> n{};
    Int128 wall = 0;
};

inline Int128 magnitude(Int128 x) {
    return x < 0 ? -x : x;
}

inline Difference int_difference(const std::array<Int128, 3>& seed, const Plane& plane, int quantum) {
    Difference d;
    if (plane.is_bisector()) {
        for (int k = 0; k < 3; ++k) {
            d.n[k] = to_int128(plane.seed[k], quantum) - seed[k];
            if (plane.lattice == nullptr) continue;
            for (int j = 0; j < 3; ++j) {
                if (plane.shift[j] == 0) continue;
                const DoubleDouble& x = plane.lattice->vector[j][k];
                d.n[k] += plane.shift[j] * (to_int128(x.high, quantum) + to_int128(x.low, quantum));
            }
        }
    } else {
        const Int128 sign = plane.kind == Plane::Kind::lower_wall ? -1 : 1;
        d.n[plane.axis] = sign;
        d.wall = sign * (to_int128(plane.wall, quantum) - seed[plane.axis]);
    }
    return d;
}

inline Int128 largest(const Difference& d) {
    Int128 m = magnitude(d.wall);
    for (auto x : d.n) m = std::max(m, magnitude(x));
    return m;
}

template <int W>
using WideRow = Row<WideInt<W>, WideInt<2 * W>>;

template <int W>
WideRow<W> wide_row(const std::array<WideInt<W>, 3>& n, const WideInt<W>& wall, bool bisector) {
    WideRow<W> r{n, {}};
    if (bisector)
        r.s = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    else
        r.s = resize<2 * W>(wall) + resize<2 * W>(wall);
    return r;
}

template <int W>
WideRow<W> wide_row(const Difference& d, bool bisector) {
    return wide_row<W>({from_int128<W>(d.n[0]), from_int128<W>(d.n[1]), from_int128<W>(d.n[2])}, from_int128<W>(d.wall),
                       bisector);
}

template <int W>
void add_power(const Plane& plane, int quantum, WideRow<W>& row) {
    if (!plane.has_power()) return;
    row.s = row.s + to_wide<2 * W>(plane.power.high, 2 * quantum) + to_wide<2 * W>(plane.power.low, 2 * quantum);
}

template <int W>
void reverse(WideRow<W>& row) {
    for (auto& n : row.n) n = -n;
    row.s = -row.s;
}

// Returns the exponent of the power of two that brings the normal of an oblique wall, or the vectors that span it, to
// integers; at most 0.
inline int normal_quantum(const Plane& wall) {
    BitRange range;
    if (wall.kind == Plane::Kind::cell_wall)
        range = BitRange::of_vectors_in(wall);
    else
        range.add(wall.seed);
    return std::min(range.low, 0);
}

template <int W>
std::array<WideInt<W>, 3> oblique_normal(const Plane& wall) {
    const int unit = normal_quantum(wall);
    std::array<WideInt<W>, 3> n;
    if (wall.kind == Plane::Kind::wall) {
        for (int k = 0; k < 3; ++k) n[k] = to_wide<W>(wall.seed[k], unit);
        return n;
    }
    const auto vector = [&](int j) {
        std::array<WideInt<W>, 3> v;
        for (int k = 0; k < 3; ++k) v[k] = to_wide<W>(wall.lattice->vector[j % 3][k].high, unit);
        return v;
    };
    const auto across = cross(vector(wall.axis + 1), vector(wall.axis + 2));
    for (int k = 0; k < 3; ++k) n[k] = resize<W>(wall.wall < 0 ? -across[k] : across[k]);
    return n;
}

// Returns the row of an oblique wall. W limbs hold N and the coordinates.
template <int W>
WideRow<W> oblique_row(const Point& p, const Plane& wall, int quantum) {
    WideRow<W> r{oblique_normal<W>(wall), {}};
    const bool of_cell = wall.kind == Plane::Kind::cell_wall;
    if (!of_cell) r.s = to_wide<2 * W>(wall.wall, normal_quantum(wall) + quantum);
    for (int k = 0; k < 3; ++k) {
        WideInt<W> from{};
        if (of_cell) from = to_wide<W>(wall.seed[k], quantum);
        if (of_cell && wall.shift[wall.axis] != 0)
            from = from + to_wide<W>(wall.lattice->vector[wall.axis][k].high, quantum);
        r.s = r.s + r.n[k] * (from - to_wide<W>(p[k], quantum));
    }
    r.s = r.s + r.s;
    return r;
}

// Returns q - p of a bisector. W limbs hold coordinates.
template <int W>
std::array<WideInt<W>, 3> wide_difference(const Point& p, const Plane& bisector, int quantum) {
    std::array<WideInt<W>, 3> n;
    for (int k = 0; k < 3; ++k) {
        n[k] = to_wide<W>(bisector.seed[k], quantum) - to_wide<W>(p[k], quantum);
        if (bisector.lattice == nullptr) continue;
        for (int j = 0; j < 3; ++j) {
            const DoubleDouble& x = bisector.lattice->vector[j][k];
            const auto length = to_wide<W>(x.high, quantum) + to_wide<W>(x.low, quantum);
            n[k] = n[k] + resize<W>(length * from_int128<1>(bisector.shift[j]));
        }
    }
    return n;
}

// Returns the row of any plane. W limbs hold coordinates.
template <int W>
WideRow<W> wide_row(const Point& p, const Plane& plane, int quantum) {
    if (plane.is_oblique()) return oblique_row<W>(p, plane, quantum);
    if (!plane.is_bisector()) {
        std::array<WideInt<W>, 3> n{};
        const bool lower = plane.kind == Plane::Kind::lower_wall;
        const WideInt<W> distance = to_wide<W>(plane.wall, quantum) - to_wide<W>(p[plane.axis], quantum);
        n[plane.axis] = from_int128<W>(lower ? -1 : 1);
        return wide_row<W>(n, lower ? -distance : distance, false);
    }
    WideRow<W> row = wide_row<W>(wide_difference<W>(p, plane, quantum), {}, true);
    add_power(plane, quantum, row);
    if (plane.is_reversed()) reverse(row);
    return row;
}

// Returns the row of any plane whose coordinates span at most 124 bits.
inline WideRow<2> narrow_row(const Point& p, const std::array<Int128, 3>& seed, const Plane& plane, int quantum) {
    if (plane.is_oblique()) return oblique_row<2>(p, plane, quantum);
    WideRow<2> row = wide_row<2>(int_difference(seed, plane, quantum), plane.is_bisector());
    add_power(plane, quantum, row);
    if (plane.is_reversed()) reverse(row);
    return row;
}

template <class T>
int sign_of(const T& x) {
    return x < 0 ? -1 : (x > 0 ? 1 : 0);
}
template <int W>
int sign_of(const WideInt<W>& x) {
    return x.sign();
}

struct WallDifference {
    double sign;
    DoubleDouble distance;
};

inline WallDifference wall_difference(const Point& p, const Plane& wall) {
    if (wall.kind == Plane::Kind::lower_wall) return {-1, two_sum(p[wall.axis], -wall.wall)};
    return {1, two_sum(wall.wall, -p[wall.axis])};
}

// Not for oblique walls.
inline double largest_difference(const Point& p, const Plane& plane) {
    if (!plane.is_bisector()) return std::abs(wall_difference(p, plane).distance.high);
    double m = 0;
    if (plane.lattice != nullptr)
        for (const DoubleDouble& x : image_differences(p, plane).x) m = std::max(m, std::abs(x.high));
    else
        for (int k = 0; k < 3; ++k) m = std::max(m, std::abs(plane.seed[k] - p[k]));
    return m;
}

// 2098 bits from the smallest subnormal to the largest double, 34 for shifts and sums
inline constexpr int widest = 36;

// For coordinates that span at most so many bits, for example because some are 0 except for rounding.
inline constexpr int middle = 4, middle_bits = 250;

// side_of_vertex() without its fast cases.
int side_of_any(const Point& p, const Plane& a, const Plane& b, const Plane& c, const Plane& d);

}  // namespace votess::exact

#include "exact/predicate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "exact/wide_float.hpp"
#include "exact/wide_int.hpp"

namespace votess::exact {
namespace {

// Exponents of the lowest and one above the highest set bit over a set of doubles.
struct BitRange {
    int low = std::numeric_limits<int>::max();
    int high = std::numeric_limits<int>::min();

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
        if (plane.kind == Plane::Kind::bisector)
            add(plane.seed);
        else
            add(plane.wall);
    }
    [[nodiscard]] int span() const { return high > low ? high - low : 0; }
    [[nodiscard]] int quantum() const { return high > low ? low : 0; }
};

// x / 2^quantum as an integer; exact when the quantum divides x and W holds it.
template <int W>
WideInt<W> to_wide(double x, int quantum) {
    int exponent = 0;
    const double fraction = std::frexp(x, &exponent);
    const auto mantissa = static_cast<std::int64_t>(std::ldexp(fraction, 53));
    const int shift = exponent - 53 - quantum;
    if (shift >= 0) return shift_left(from_int128<W>(mantissa), shift);
    return from_int128<W>(shift <= -64 ? 0 : mantissa >> -shift);
}

Int128 to_int128(double x, int quantum) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const auto fraction = bits & ((1ull << 52) - 1);
    const int biased = static_cast<int>((bits >> 52) & 0x7ff);
    const Int128 mantissa = biased == 0 ? fraction : fraction | (1ull << 52);
    const int shift = (biased == 0 ? 1 : biased) - 1075 - quantum;
    const Int128 value = shift >= 0 ? (shift < 127 ? mantissa << shift : 0) : (shift > -64 ? mantissa >> -shift : 0);
    return (bits >> 63) != 0 ? -value : value;
}

// A plane in integer units: 2 N.X <= S.
template <class N, class S>
struct Row {
    std::array<N, 3> n;
    S s;
};

using SmallRow = Row<Int128, Int128>;
// N of a bisector, or the unit normal and distance of a wall.
struct Difference {
    std::array<Int128, 3> n{};
    Int128 wall = 0;
};

Int128 magnitude(Int128 x) {
    return x < 0 ? -x : x;
}

Difference int_difference(const std::array<Int128, 3>& seed, const Plane& plane, int quantum) {
    Difference d;
    switch (plane.kind) {
        case Plane::Kind::bisector:
            for (int k = 0; k < 3; ++k) d.n[k] = to_int128(plane.seed[k], quantum) - seed[k];
            break;
        case Plane::Kind::lower_wall:
            d.n[plane.axis] = -1;
            d.wall = seed[plane.axis] - to_int128(plane.wall, quantum);
            break;
        case Plane::Kind::upper_wall:
            d.n[plane.axis] = 1;
            d.wall = to_int128(plane.wall, quantum) - seed[plane.axis];
            break;
    }
    return d;
}

Int128 largest(const Difference& d) {
    Int128 m = magnitude(d.wall);
    for (auto x : d.n) m = std::max(m, magnitude(x));
    return m;
}

bool is_bisector(const Plane& plane) {
    return plane.kind == Plane::Kind::bisector;
}

// Differences below 2^23: every intermediate of the determinant stays below 2^126.
SmallRow small_row(const Difference& d, bool bisector) {
    SmallRow r{d.n, 2 * d.wall};
    if (bisector) r.s = d.n[0] * d.n[0] + d.n[1] * d.n[1] + d.n[2] * d.n[2];
    return r;
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

// The widest case: coordinates themselves as W limbs.
template <int W>
WideRow<W> wide_row(const Point& p, const Plane& plane, int quantum) {
    std::array<WideInt<W>, 3> n{};
    WideInt<W> wall{};
    switch (plane.kind) {
        case Plane::Kind::bisector:
            for (int k = 0; k < 3; ++k) n[k] = to_wide<W>(plane.seed[k], quantum) - to_wide<W>(p[k], quantum);
            break;
        case Plane::Kind::lower_wall:
            n[plane.axis] = from_int128<W>(-1);
            wall = to_wide<W>(p[plane.axis], quantum) - to_wide<W>(plane.wall, quantum);
            break;
        case Plane::Kind::upper_wall:
            n[plane.axis] = from_int128<W>(1);
            wall = to_wide<W>(plane.wall, quantum) - to_wide<W>(p[plane.axis], quantum);
            break;
    }
    return wide_row<W>(n, wall, is_bisector(plane));
}

template <class N>
auto cross(const std::array<N, 3>& a, const std::array<N, 3>& b) {
    return std::array{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

template <class A, class B>
auto dot(const std::array<A, 3>& a, const std::array<B, 3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

int sign_of(Int128 x) {
    return x < 0 ? -1 : (x > 0 ? 1 : 0);
}
template <int W>
int sign_of(const WideInt<W>& x) {
    return x.sign();
}

// Cramer: X = (Sa (Nb x Nc) + Sb (Nc x Na) + Sc (Na x Nb)) / (2 D), D = Na.(Nb x Nc); outside when 2 Nd.X > Sd.
// Width: with |N| < 2^b, minors < 2^(2b+1), D < 2^(3b+3), S < 2^(2b+2), the sum < 2^(5b+8).
template <class R>
int side(const R& a, const R& b, const R& c, const R& d) {
    const auto bc = cross(b.n, c.n), ca = cross(c.n, a.n), ab = cross(a.n, b.n);
    const auto determinant = dot(a.n, bc);
    const auto excess = dot(d.n, bc) * a.s + dot(d.n, ca) * b.s + dot(d.n, ab) * c.s - determinant * d.s;
    return sign_of(excess) * sign_of(determinant);
}

constexpr int widest = 36;  // 2098 bits from the smallest subnormal to the largest double, plus sign and sum

template <class Real>
Real scale_by_power(Real x, int exponent) {
    if constexpr (std::is_same_v<Real, WideFloat>) {
        return ldexp(x, exponent);
    } else {
        // In steps that neither overflow nor underflow in between.
        while (exponent > 500) x *= static_cast<Real>(0x1p500), exponent -= 500;
        while (exponent < -500) x *= static_cast<Real>(0x1p-500), exponent += 500;
        return x * static_cast<Real>(std::ldexp(1.0, exponent));
    }
}

template <class Real, int W>
Scaled<Real> scaled(const WideInt<W>& a) {
    if constexpr (std::is_same_v<Real, WideFloat>) {
        const WideInt<W> m = a.negative() ? -a : a;
        WideFloat x = 0;
        for (int i = W - 1; i >= 0; --i) x = ldexp(x, 64) + m.limb[i];
        return {a.negative() ? WideFloat(-x) : x, 0};
    } else {
        return to_scaled<Real>(a);
    }
}

template <class Real, int W>
std::array<Real, 3> position(const WideRow<W>& a, const WideRow<W>& b, const WideRow<W>& c, int quantum) {
    const auto bc = cross(b.n, c.n), ca = cross(c.n, a.n), ab = cross(a.n, b.n);
    const auto determinant = scaled<Real>(dot(a.n, bc));
    std::array<Real, 3> x{};
    for (int k = 0; k < 3; ++k) {
        const auto numerator = scaled<Real>(a.s * bc[k] + b.s * ca[k] + c.s * ab[k]);
        x[k] = scale_by_power<Real>(numerator.mantissa / determinant.mantissa,
                                    numerator.exponent - determinant.exponent - 1 + quantum);
    }
    return x;
}

}  // namespace

int side_of_vertex(const Point& p, const Plane& a, const Plane& b, const Plane& c, const Plane& d) {
    BitRange range;
    range.add(p);
    for (const Plane* plane : {&a, &b, &c, &d}) range.add(*plane);
    const int q = range.quantum();
    if (range.span() > 124) {
        return side(wide_row<widest>(p, a, q), wide_row<widest>(p, b, q), wide_row<widest>(p, c, q),
                    wide_row<widest>(p, d, q));
    }
    const std::array<Int128, 3> seed{to_int128(p[0], q), to_int128(p[1], q), to_int128(p[2], q)};
    const std::array<Difference, 4> n{int_difference(seed, a, q), int_difference(seed, b, q),
                                      int_difference(seed, c, q), int_difference(seed, d, q)};
    const std::array<bool, 4> bisector{is_bisector(a), is_bisector(b), is_bisector(c), is_bisector(d)};
    const Int128 m = std::max({largest(n[0]), largest(n[1]), largest(n[2]), largest(n[3])});
    if (m < (1 << 23)) {
        return side(small_row(n[0], bisector[0]), small_row(n[1], bisector[1]), small_row(n[2], bisector[2]),
                    small_row(n[3], bisector[3]));
    }
    auto at_width = [&]<int W>() {
        return side(wide_row<W>(n[0], bisector[0]), wide_row<W>(n[1], bisector[1]), wide_row<W>(n[2], bisector[2]),
                    wide_row<W>(n[3], bisector[3]));
    };
    // 5 * 61 + 8 < 320 bits and 5 * 125 + 8 < 640 bits.
    return m < (static_cast<Int128>(1) << 61) ? at_width.template operator()<1>() : at_width.template operator()<2>();
}

template <class Real>
std::array<Real, 3> vertex_position(const Point& p, const Plane& a, const Plane& b, const Plane& c) {
    BitRange range;
    range.add(p);
    for (const Plane* plane : {&a, &b, &c}) range.add(*plane);
    const int q = range.quantum();
    if (range.span() > 124) {
        return position<Real, widest>(wide_row<widest>(p, a, q), wide_row<widest>(p, b, q), wide_row<widest>(p, c, q),
                                      q);
    }
    const std::array<Int128, 3> seed{to_int128(p[0], q), to_int128(p[1], q), to_int128(p[2], q)};
    const Difference da = int_difference(seed, a, q), db = int_difference(seed, b, q), dc = int_difference(seed, c, q);
    const Int128 m = std::max({largest(da), largest(db), largest(dc)});
    auto at_width = [&]<int W>() {
        return position<Real, W>(wide_row<W>(da, is_bisector(a)), wide_row<W>(db, is_bisector(b)),
                                 wide_row<W>(dc, is_bisector(c)), q);
    };
    return m < (static_cast<Int128>(1) << 61) ? at_width.template operator()<1>() : at_width.template operator()<2>();
}

template std::array<double, 3> vertex_position(const Point&, const Plane&, const Plane&, const Plane&);
template std::array<Quad, 3> vertex_position(const Point&, const Plane&, const Plane&, const Plane&);
template std::array<WideFloat, 3> vertex_position(const Point&, const Plane&, const Plane&, const Plane&);

}  // namespace votess::exact

#include "exact/predicate.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include "core/arithmetic.hpp"
#include "exact/integer/normals.hpp"
#include "exact/integer/rows.hpp"
#include "exact/integer/vertex.hpp"
#include "exact/integer/wide_int.hpp"
#include "exact/pair_vertex.hpp"
#include "exact/wide_float.hpp"

namespace votess::exact {
namespace {

// Cramer: X = V / (2 D) with V = Sa (Nb x Nc) + Sb (Nc x Na) + Sc (Na x Nb), D = Na.(Nb x Nc). X lies outside d when
// Nd.V - Sd D has the sign of D. Width: with |N| < 2^b, minors < 2^(2b+1), D < 2^(3b+3), S < 2^(2b+2), the sum <
// 2^(5b+6.2).
template <class R>
int side_of_rows(const R& a, const R& b, const R& c, const R& d) {
    const auto bc = cross(b.n, c.n), ca = cross(c.n, a.n), ab = cross(a.n, b.n);
    const auto determinant = dot(a.n, bc);
    const auto excess = dot(d.n, bc) * a.s + dot(d.n, ca) * b.s + dot(d.n, ab) * c.s - determinant * d.s;
    return sign_of(excess) * sign_of(determinant);
}

// A plane in 64-bit words: N, or the sign and the distance of a wall.
struct WordRow {
    std::array<std::int64_t, 3> n{};
    std::int64_t wall = 0;
};
constexpr int bits_for_int64 = 11;   // 5 * 11 + 6.2 < 63
constexpr int bits_for_int128 = 24;  // 5 * 24 + 6.2 < 127
constexpr int max_bits = 60;         // 5 * 61 + 6.2 < 319, with one bit more for the sum of two parts

// Writes the planes in their largest common unit. Returns the bits of the largest component, or 0 when they do not fit.
int word_rows(const Point& p, const std::array<const Plane*, 4>& planes, std::array<WordRow, 4>& rows) {
    double largest = 0;
    for (const Plane* plane : planes) {
        if (plane->has_power() || plane->is_oblique()) return 0;
        largest = std::max(largest, largest_difference(p, *plane));
    }
    // largest < 2^(exponent - 1022); the unit 2^(exponent - 1022 - max_bits) and its inverse must be normal.
    const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(largest) >> 52);
    if (exponent <= max_bits || exponent == 0x7ff) return 0;
    const double unit = power_of_two(exponent - 1022 - max_bits), per_unit = power_of_two(1022 - exponent + max_bits);
    std::uint64_t any = 0, sizes = 0;
    bool whole = true;
    auto units = [&](double x) {
        const auto n = static_cast<std::int64_t>(x * per_unit);
        whole &= static_cast<double>(n) * unit == x;
        return n;
    };
    auto words = [&](DoubleDouble x) {
        if (x.low != x.low) return whole = false, std::int64_t{0};  // overflow
        const std::int64_t n = units(x.high) + (x.low != 0 ? units(x.low) : 0);
        any |= static_cast<std::uint64_t>(n);
        sizes |= static_cast<std::uint64_t>(std::abs(n));
        return n;
    };
    for (int i = 0; i < 4; ++i) {
        const Plane& plane = *planes[i];
        rows[i] = {};
        if (plane.is_bisector()) {
            const Differences difference = differences(p, plane);
            if (!difference.exact) return 0;
            for (int k = 0; k < 3; ++k) rows[i].n[k] = words(difference.x[k]);
        } else {
            const auto [sign, distance] = wall_difference(p, plane);
            rows[i].n[plane.axis] = sign < 0 ? -1 : 1;
            rows[i].wall = words(distance);
        }
        if (!whole) return 0;
    }
    const int zeros = std::countr_zero(any);
    for (int i = 0; i < 4; ++i) {
        rows[i].wall >>= zeros;
        if (planes[i]->is_bisector())
            for (auto& x : rows[i].n) x >>= zeros;
    }
    return 64 - std::countl_zero(sizes) - zeros;
}

template <class N, class S>
Row<N, S> row_of(const WordRow& words, const Plane& plane) {
    Row<N, S> r{{words.n[0], words.n[1], words.n[2]}, 2 * static_cast<S>(words.wall)};
    if (plane.is_bisector()) {
        r.s = 0;
        for (const auto& x : r.n) r.s += static_cast<S>(x) * x;
    }
    if (plane.is_reversed()) {
        for (auto& x : r.n) x = -x;
        r.s = -r.s;
    }
    return r;
}

template <class Real>
Real scale_by_power(Real x, int exponent) {
    if constexpr (!std::is_same_v<Real, double>) {
        return ldexp(x, exponent);
    } else {
        // In steps that neither overflow nor underflow.
        while (exponent > 500) x *= 0x1p500, exponent -= 500;
        while (exponent < -500) x *= 0x1p-500, exponent += 500;
        return x * power_of_two(exponent);
    }
}

template <class Real, int W>
Scaled<Real> scaled(const WideInt<W>& a) {
    if constexpr (std::is_same_v<Real, WideFloat>) {
        return {WideFloat(a, 0), 0};
    } else if constexpr (std::is_same_v<Real, Quad>) {
        return {Quad(a), 0};
    } else {
        return to_scaled(a);
    }
}

// The vertex is numerator / (2 determinant), in quanta.
template <int W>
struct Fractions {
    std::array<WideInt<4 * W>, 3> numerator;
    WideInt<3 * W> determinant;
};

// Equal for all types of positions, so it is compiled once for each width.
template <int W>
[[gnu::noinline]] Fractions<W> fractions(const WideRow<W>& a, const WideRow<W>& b, const WideRow<W>& c) {
    const auto bc = cross(b.n, c.n), ca = cross(c.n, a.n), ab = cross(a.n, b.n);
    Fractions<W> result{{}, dot(a.n, bc)};
    for (int k = 0; k < 3; ++k) result.numerator[k] = a.s * bc[k] + b.s * ca[k] + c.s * ab[k];
    return result;
}

template <class Real, int W>
std::array<Real, 3> position(const WideRow<W>& a, const WideRow<W>& b, const WideRow<W>& c, int quantum) {
    const Fractions<W> vertex = fractions<W>(a, b, c);
    const auto determinant = scaled<Real>(vertex.determinant);
    std::array<Real, 3> x{};
    if constexpr (!std::is_same_v<Real, double>) {  // division takes most of the time
        const Real inverse = 1 / determinant.mantissa;
        for (int k = 0; k < 3; ++k) x[k] = ldexp(scaled<Real>(vertex.numerator[k]).mantissa * inverse, quantum - 1);
        return x;
    }
    for (int k = 0; k < 3; ++k) {
        const auto numerator = scaled<Real>(vertex.numerator[k]);
        x[k] = scale_by_power<Real>(numerator.mantissa / determinant.mantissa,
                                    numerator.exponent - determinant.exponent - 1 + quantum);
    }
    return x;
}

// The side of a vertex on one, two or three walls of the box that are so far from all seeds that the direction to the
// vertex decides. Such numbers are narrow, those of the walls are not. Returns nothing for other vertices and for
// directions along the plane.
//
// Let x_m = w_m on the walls. Cramer's rule for the other planes, whose rows are N and S, gives
//     (2 Nd.x - Sd) D = 2 sum w_m E_m + R.
// one wall k:      D = (Na x Nb)_k                 E = Nd.(Na x Nb)                     |R| <= |Sa||Nd||Nb| + ...
// two walls i, j:  D = Na_k                        E_m = Nd_m Na_k - Nd_k Na_m          |R| <= |Sa||Nd| + |Sd||Na|
// three walls:     D = 1                           E_m = Nd_m                           |R| <= |Sd|
// In integers the sum of +-E_m is 0 or at least 1. All |w_m| are equal to a difference e, so |2 w_m| times that sum
// decides if it is more than 2 e sum |E_m| + |R|.
std::optional<int> side_of_far_vertex(const Point& p, const std::array<const Plane*, 3>& vertex, const Plane& d) {
    std::array<const Plane*, 4> bisectors{&d};
    std::array<std::size_t, 3> across{};
    std::array<bool, 3> is_across{};
    std::array<int, 3> sign{};
    std::size_t walls = 0, planes = 1;
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0, seed = 0;
    for (const Plane* plane : vertex) {
        if (plane->is_oblique()) return std::nullopt;
        if (plane->is_bisector()) {
            bisectors[planes++] = plane;
            continue;
        }
        const auto k = static_cast<std::size_t>(plane->axis);
        across[walls] = k;
        is_across[k] = true;
        sign[walls++] = wall_sign(*plane);
        nearest = std::min(nearest, std::abs(plane->wall));
        farthest = std::max(farthest, std::abs(plane->wall));
        seed = std::max(seed, std::abs(p[k]));
        if (plane->wall * wall_sign(*plane) < 0) return std::nullopt;  // both walls are on one side of the origin
    }
    if (walls == 0 || !d.is_bisector() || !(nearest > 0x1p60 * seed)) return std::nullopt;
    double power = 0;
    for (std::size_t i = 0; i < planes; ++i) {
        if (bisectors[i]->is_reversed()) return std::nullopt;
        power = std::max(power, std::abs(bisectors[i]->power.high));
    }

    const std::span used = std::span(bisectors).first(planes);
    Scratch<WordVector> n(planes);
    std::optional<int> unit = word_normals(p, used, n);
    if (!unit) return std::nullopt;
    *unit += reduce(used, n);
    if (std::abs(*unit) > 400) return std::nullopt;
    const double per_unit = power_of_two(-*unit), far = nearest * per_unit;
    double longest = 0;
    for (const WordVector& vector : n.all())
        longest = std::max(longest, length3(static_cast<double>(vector[0]), static_cast<double>(vector[1]),
                                            static_cast<double>(vector[2])));
    const double square = longest * longest + power * per_unit * per_unit;
    double rest = square * (planes == 3 ? 3 * longest * longest : planes == 2 ? 2 * longest : 1);
    const double apart = (farthest - nearest) * per_unit + seed * per_unit;
    if (!(0x1.8p0 * far > rest) || !(far < 0x1p900)) return std::nullopt;

    if (walls == 1) {
        const std::size_t k = across[0], i = (k + 1) % 3, j = (k + 2) % 3;
        const int turn = WordCross(n[1], n[2]).turn(n[0]);
        const Int128 divisor = static_cast<Int128>(n[1][i]) * n[2][j] - static_cast<Int128>(n[1][j]) * n[2][i];
        if (turn == 0) return std::nullopt;
        return sign[0] * turn * sign_of(divisor);
    }
    Int128 sum = 0;
    double sizes = 0;
    const std::size_t k = !is_across[0] ? 0 : !is_across[1] ? 1 : 2;  // of two walls: along both
    for (std::size_t m = 0; m < walls; ++m) {
        const std::size_t i = across[m];
        const Int128 by =
            walls == 3 ? n[0][i] : static_cast<Int128>(n[0][i]) * n[1][k] - static_cast<Int128>(n[0][k]) * n[1][i];
        sum += sign[m] * by;
        sizes += std::abs(static_cast<double>(by));
    }
    rest += 2 * apart * sizes;
    if (sum == 0 || !(0x1.8p0 * far * std::abs(static_cast<double>(sum)) > rest)) return std::nullopt;
    return sign_of(sum) * (walls == 3 ? 1 : sign_of(n[1][k]));
}

}  // namespace

int side_of_any(const Point& p, const Plane& a, const Plane& b, const Plane& c, const Plane& d) {
    if (const auto side = side_of_far_vertex(p, {&a, &b, &c}, d)) return *side;
    BitRange range;
    range.add(p);
    for (const Plane* plane : {&a, &b, &c, &d}) range.add(*plane);
    const int q = range.quantum();
    const auto side = [&]<int W>() {
        return side_of_rows(wide_row<W>(p, a, q), wide_row<W>(p, b, q), wide_row<W>(p, c, q), wide_row<W>(p, d, q));
    };
    if (range.span() > middle_bits) return side.template operator()<widest>();
    if (range.span() > 124) return side.template operator()<middle>();
    const std::array<Int128, 3> seed{to_int128(p[0], q), to_int128(p[1], q), to_int128(p[2], q)};
    auto row = [&](const Plane& plane) { return narrow_row(p, seed, plane, q); };
    return side_of_rows(row(a), row(b), row(c), row(d));  // 5 * 125 + 8 < 640 bits
}

int side_of_vertex(const Point& p, const Plane& a, const Plane& b, const Plane& c, const Plane& d) {
    std::array<WordRow, 4> rows;
    const int bits = word_rows(p, {&a, &b, &c, &d}, rows);
    if (bits == 0) {
        const int side = side_in_pairs(p, a, b, c, d);
        return side != 0 ? side : side_of_any(p, a, b, c, d);
    }
    auto side = [&]<class N>(N) {
        return side_of_rows(row_of<N, N>(rows[0], a), row_of<N, N>(rows[1], b), row_of<N, N>(rows[2], c),
                            row_of<N, N>(rows[3], d));
    };
    if (bits <= bits_for_int64) return side(std::int64_t{});
    if (bits <= bits_for_int128) return side(Int128{});
    auto row = [](const WordRow& words, const Plane& plane) {
        const auto r = row_of<std::int64_t, Int128>(words, plane);
        return IntRow{r.n, r.s};
    };
    return IntVertex(row(rows[0], a), row(rows[1], b), row(rows[2], c)).side(row(rows[3], d));
}

namespace {

// Returns decide(row a, row b) at a width that holds any two planes.
template <class Decide>
auto decide_on_rows(const Point& p, const Plane& a, const Plane& b, Decide decide) {
    BitRange range;
    range.add(p);
    range.add(a);
    range.add(b);
    const int q = range.quantum();
    if (range.span() <= 124) return decide(wide_row<2>(p, a, q), wide_row<2>(p, b, q));
    return decide(wide_row<widest>(p, a, q), wide_row<widest>(p, b, q));
}

}  // namespace

bool same_plane(const Point& p, const Plane& a, const Plane& b) {
    return decide_on_rows(p, a, b, [](const auto& u, const auto& v) {
        const auto turned = cross(u.n, v.n);
        for (int k = 0; k < 3; ++k)
            if (!turned[k].zero() || (u.s * v.n[k] - v.s * u.n[k]).sign() != 0) return false;
        return dot(u.n, v.n).sign() > 0;
    });
}

bool longer_normal(const Point& p, const Plane& a, const Plane& b) {
    return decide_on_rows(p, a, b,
                          [](const auto& u, const auto& v) { return (dot(u.n, u.n) - dot(v.n, v.n)).sign() > 0; });
}

int farther(const Point& p, const Plane& a, const Plane& b) {
    return decide_on_rows(p, a, b, [](const auto& u, const auto& v) { return (u.s - v.s).sign(); });
}

template <class Real>
std::array<Real, 3> vertex_position(const Point& p, const Plane& a, const Plane& b, const Plane& c) {
    BitRange range;
    range.add(p);
    for (const Plane* plane : {&a, &b, &c}) range.add(*plane);
    const int q = range.quantum();
    const auto solve = [&]<int W>() {
        return position<Real, W>(wide_row<W>(p, a, q), wide_row<W>(p, b, q), wide_row<W>(p, c, q), q);
    };
    if constexpr (std::is_same_v<Real, WideFloat>) {  // rare, so one width is enough
        return solve.template operator()<widest>();
    } else {
        if (range.span() > middle_bits) return solve.template operator()<widest>();
        if (range.span() > 124) return solve.template operator()<middle>();
        const std::array<Int128, 3> seed{to_int128(p[0], q), to_int128(p[1], q), to_int128(p[2], q)};
        if (!a.plain() || !b.plain() || !c.plain())
            return position<Real, 2>(narrow_row(p, seed, a, q), narrow_row(p, seed, b, q), narrow_row(p, seed, c, q),
                                     q);
        const Difference da = int_difference(seed, a, q), db = int_difference(seed, b, q),
                         dc = int_difference(seed, c, q);
        const Int128 m = std::max({largest(da), largest(db), largest(dc)});
        auto at_width = [&]<int W>() {
            return position<Real, W>(wide_row<W>(da, a.is_bisector()), wide_row<W>(db, b.is_bisector()),
                                     wide_row<W>(dc, c.is_bisector()), q);
        };
        return m < (static_cast<Int128>(1) << 61) ? at_width.template operator()<1>()
                                                  : at_width.template operator()<2>();
    }
}

template <class Real>
std::array<Real, 3> difference(const Point& p, const Plane& bisector) {
    std::array<Real, 3> d;
    if (bisector.lattice == nullptr) {
        for (int k = 0; k < 3; ++k) d[k] = static_cast<Real>(bisector.seed[k]) - static_cast<Real>(p[k]);
        return d;
    }
    const Differences sums = image_differences(p, bisector);
    if (sums.exact) {
        for (int k = 0; k < 3; ++k) d[k] = static_cast<Real>(sums.x[k].high) + static_cast<Real>(sums.x[k].low);
        return d;
    }
    BitRange range;
    range.add(p);
    range.add(bisector);
    const int q = range.quantum();
    const auto row = wide_row<widest>(p, bisector, q);
    for (int k = 0; k < 3; ++k) {
        const auto number = scaled<Real>(row.n[k]);
        d[k] = scale_by_power<Real>(number.mantissa, number.exponent + q);
    }
    return d;
}

template <class Real>
Real height(const Point& p, const Plane& plane, int exponent) {
    BitRange range;
    range.add(p);
    range.add(plane);
    const int q = range.quantum();
    int unit = q;  // of N
    if (plane.is_oblique()) unit = normal_quantum(plane) * (plane.kind == Plane::Kind::cell_wall ? 2 : 1);
    const auto half = [&]<int W>() {
        const auto s = scaled<Real>(wide_row<W>(p, plane, q).s);
        return scale_by_power<Real>(s.mantissa, s.exponent + unit + q - 1 + exponent);
    };
    if constexpr (std::is_same_v<Real, WideFloat>) {
        return half.template operator()<widest>();
    } else {
        if (range.span() > middle_bits) return half.template operator()<widest>();
        return range.span() > 124 ? half.template operator()<middle>() : half.template operator()<2>();
    }
}

template double height(const Point&, const Plane&, int);
template Quad height(const Point&, const Plane&, int);
template WideFloat height(const Point&, const Plane&, int);
template std::array<double, 3> difference(const Point&, const Plane&);
template std::array<Quad, 3> difference(const Point&, const Plane&);
template std::array<WideFloat, 3> difference(const Point&, const Plane&);
template std::array<double, 3> vertex_position(const Point&, const Plane&, const Plane&, const Plane&);
template std::array<Quad, 3> vertex_position(const Point&, const Plane&, const Plane&, const Plane&);
template std::array<WideFloat, 3> vertex_position(const Point&, const Plane&, const Plane&, const Plane&);

}  // namespace votess::exact

#include "exact/insphere.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "core/arithmetic.hpp"
#include "exact/determinant.hpp"
#include "exact/double_double.hpp"
#include "exact/integer/rows.hpp"
#include "exact/integer/wide_int.hpp"

namespace votess::exact {
namespace {

constexpr double unit = 0x1p-53;
constexpr double orient_factor = 50 * unit, insphere_factor = 400 * unit;
// An upper bound of all underflow, with coordinates below 2^90.
constexpr double underflow = 1e-200;

constexpr auto lift = [](const auto& a) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; };

// N points minus a last one, rounded, and the exact rounding errors.
template <std::size_t N>
struct PointRows {
    std::array<std::array<double, 3>, N> high;
    std::array<std::array<double, 3>, N> low;

    void find_low(const std::array<const Point*, N>& points, const Point& last) {
        for (std::size_t i = 0; i < N; ++i)
            for (int k = 0; k < 3; ++k) low[i][k] = two_sum((*points[i])[k], -last[k]).low;
    }
};

// Writes the differences as integers below 2^61 in units of a power of two. Returns false if that would round.
template <std::size_t N>
bool to_int64(const PointRows<N>& d, std::array<std::array<std::int64_t, 3>, N>& out) {
    double largest = 0;
    for (const auto& row : d.high)
        for (double x : row) largest = std::max(largest, std::abs(x));
    const int shift = 60 - exponent_above(largest);
    if (shift < 0 || shift > 1000) return false;  // scaling up is exact
    const double scale = power_of_two(shift);
    bool exact = true;
    for (std::size_t i = 0; i < N; ++i)
        for (int k = 0; k < 3; ++k) {
            const double high = d.high[i][k] * scale, low = d.low[i][k] * scale;
            const auto h = static_cast<std::int64_t>(high), l = static_cast<std::int64_t>(low);
            exact &= (static_cast<double>(h) == high) & (static_cast<double>(l) == low);
            out[i][k] = h + l;
        }
    return exact;
}

template <int W, std::size_t N>
std::array<std::array<WideInt<W>, 3>, N> wide_rows(const PointRows<N>& d, int quantum) {
    std::array<std::array<WideInt<W>, 3>, N> out;
    for (std::size_t i = 0; i < N; ++i)
        for (int k = 0; k < 3; ++k) out[i][k] = to_wide<W>(d.high[i][k], quantum) + to_wide<W>(d.low[i][k], quantum);
    return out;
}

// Returns decide(rows) of the differences as integers of one unit. They are so narrow that determinants of degree at
// most 5 fit: these are below 2^(5b + 8) when the differences are below 2^b.
template <std::size_t N, class Decide>
auto decide_on_rows(const PointRows<N>& d, Decide decide) {
    if (std::array<std::array<std::int64_t, 3>, N> small; to_int64(d, small)) {
        std::array<std::array<WideInt<1>, 3>, N> rows;
        for (std::size_t i = 0; i < N; ++i)
            for (int k = 0; k < 3; ++k) rows[i][k] = from_int128<1>(small[i][k]);
        return decide(rows);
    }
    BitRange range;
    for (const auto& part : {d.high, d.low})
        for (const auto& row : part) range.add(row);
    // One bit more for a sum of two: 5 * 124 + 8 < 640 bits.
    if (range.span() <= 123) return decide(wide_rows<2>(d, range.quantum()));
    return decide(wide_rows<widest>(d, range.quantum()));
}

// Divides exact components by their greatest common divisor, if they are integers times a power of two near 1.
void divide_out(RoundedNormal& normal) {
    constexpr double units = 0x1p60;
    std::array<std::int64_t, 3> whole{};
    std::int64_t divisor = 0;
    for (int k = 0; k < 3; ++k) {
        whole[k] = static_cast<std::int64_t>(normal.n[k] * units);
        if (normal.error[k] != 0 || static_cast<double>(whole[k]) != normal.n[k] * units) return;
        divisor = std::gcd(divisor, whole[k]);
    }
    if (divisor == 0) return;
    double largest = 0;
    for (int k = 0; k < 3; ++k) {
        normal.n[k] = static_cast<double>(whole[k] / divisor);
        largest = std::max(largest, std::abs(normal.n[k]));
    }
    for (double& x : normal.n) x = std::ldexp(x, -std::ilogb(largest));
}

template <int W>
RoundedNormal normal_of(const std::array<WideInt<W>, 3>& cross) {
    std::array<Scaled<double>, 3> parts;
    int top = std::numeric_limits<int>::min(), count = 0;
    for (int k = 0; k < 3; ++k) {
        parts[k] = to_scaled(cross[k]);
        if (parts[k].mantissa == 0) continue;
        top = std::max(top, parts[k].exponent);
        ++count;
    }
    RoundedNormal normal;
    for (int k = 0; k < 3; ++k) {
        const auto [mantissa, exponent] = parts[k];
        if (mantissa == 0) continue;
        if (count == 1) {
            normal.n[k] = mantissa > 0 ? 1 : -1;
            return normal;
        }
        constexpr double quantum = 0x1p-108;
        const double value = std::ldexp(mantissa, std::max(exponent - top, -1000) + 1);
        normal.n[k] = std::rint(value / quantum) * quantum;
        const bool exact = normal.n[k] == value && (cross[k] - to_wide<W>(mantissa, -exponent)).zero();
        if (!exact) normal.error[k] = 2 * unit * std::abs(value) + quantum;
    }
    divide_out(normal);
    return normal;
}

template <std::size_t N>
void subtract(const std::array<const Point*, N>& points, const Point& last, PointRows<N>& d,
              std::array<double, 3>& largest) {
    largest = {};
    for (std::size_t i = 0; i < N; ++i)
        for (int k = 0; k < 3; ++k) {
            d.high[i][k] = (*points[i])[k] - last[k];
            largest[k] = std::max(largest[k], std::abs(d.high[i][k]));
        }
}

}  // namespace

int orient(const Point& a, const Point& b, const Point& c, const Point& d) {
    const std::array points{&a, &b, &c};
    PointRows<3> rows;
    std::array<double, 3> largest;
    subtract<3>(points, d, rows, largest);
    const double estimate = determinant(rows.high[0], rows.high[1], rows.high[2]);
    const double bound = orient_factor * (largest[0] * largest[1] * largest[2]) + underflow;
    if (std::abs(estimate) > bound) return sign_of(estimate);
    rows.find_low(points, d);
    return decide_on_rows(rows, [](const auto& r) { return determinant(r[0], r[1], r[2]).sign(); });
}

RoundedNormal triangle_normal(const Point& a, const Point& b, const Point& c) {
    PointRows<2> rows;
    std::array<double, 3> largest;
    subtract<2>({&b, &c}, a, rows, largest);
    rows.find_low({&b, &c}, a);
    return decide_on_rows(rows, [](const auto& r) {
        const auto minor = [&r](int i, int j) { return r[0][i] * r[1][j] - r[1][i] * r[0][j]; };
        return normal_of(std::array{minor(1, 2), minor(2, 0), minor(0, 1)});
    });
}

int insphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p) {
    const std::array points{&a, &b, &c, &d};
    PointRows<4> rows;
    std::array<double, 3> largest;
    subtract<4>(points, p, rows, largest);
    const auto& h = rows.high;
    const double estimate = lifted_determinant(h[0], h[1], h[2], h[3], lift);
    const double longest = std::max(std::max(lift(h[0]), lift(h[1])), std::max(lift(h[2]), lift(h[3])));
    const double bound = insphere_factor * (largest[0] * largest[1] * largest[2] * longest) + underflow;
    if (std::abs(estimate) > bound) return sign_of(estimate);
    rows.find_low(points, p);
    return decide_on_rows(rows, [](const auto& r) { return lifted_determinant(r[0], r[1], r[2], r[3], lift).sign(); });
}

}  // namespace votess::exact

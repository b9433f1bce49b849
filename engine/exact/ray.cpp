#include "exact/ray.hpp"

#include <cmath>

#include "core/vector3.hpp"
#include "exact/integer/rows.hpp"

namespace votess::exact {
namespace {

// Twice a time as a fraction, in units of a coordinate over units of the direction.
template <int W>
struct Fraction {
    WideInt<2 * W> numerator, denominator;
};

struct Units {
    int coordinate, direction;
};

template <int W>
Fraction<W> fraction_of(const Ray& ray, const Crossing& crossing, const Units& units) {
    const auto one = from_int128<2 * W>(1);
    if (crossing.kind == Crossing::Kind::time) {
        if (crossing.time == 0) return {{}, one};
        const auto [mantissa, exponent] = mantissa_of(crossing.time);
        const auto whole = from_int128<2 * W>(mantissa);
        const int shift = exponent + 1 + units.direction - units.coordinate;
        if (shift >= 0) return {shift_left(whole, shift), one};
        return {whole, shift_left(one, -shift)};
    }
    std::array<WideInt<W>, 3> d;
    for (std::size_t k = 0; k < 3; ++k) d[k] = to_wide<W>(ray.direction[k], units.direction);
    WideRow<W> row = wide_row<W>(ray.origin, crossing.to, units.coordinate);
    if (crossing.kind == Crossing::Kind::bisector) {
        const WideRow<W> from = wide_row<W>(ray.origin, crossing.from, units.coordinate);
        for (std::size_t k = 0; k < 3; ++k) row.n[k] = row.n[k] - from.n[k];
        row.s = row.s - from.s;
    }
    return {row.s, dot(row.n, d)};
}

// Returns decide(fractions), at a width that holds them. Bits: |n| < 2^125, so a difference of two and d take 126 and
// 124, a denominator 252 and a numerator 254. A time takes 53 and its shift.
template <class Decide, class... Crossings>
auto decide_on_fractions(const Ray& ray, Decide decide, const Crossings&... crossings) {
    constexpr int narrow_bits = 124, max_shift_of_time = 190;
    BitRange range, direction;
    range.add(ray.origin);
    direction.add(ray.direction);
    const auto add = [&](const Crossing& c) {
        if (c.kind == Crossing::Kind::bisector) range.add(c.from);
        if (c.kind != Crossing::Kind::time) range.add(c.to);
    };
    (add(crossings), ...);
    const Units units{range.quantum(), direction.quantum()};
    const auto fits = [&](const Crossing& c) {
        return c.kind != Crossing::Kind::time || c.time == 0 ||
               std::abs(mantissa_of(c.time).exponent + 1 + units.direction - units.coordinate) <= max_shift_of_time;
    };
    if (range.span() <= narrow_bits && direction.span() <= narrow_bits && (fits(crossings) && ...))
        return decide(fraction_of<2>(ray, crossings, units)...);
    return decide(fraction_of<widest>(ray, crossings, units)...);
}

}  // namespace

int approach(const Ray& ray, const Crossing& crossing) {
    return decide_on_fractions(
        ray, [](const auto& f) { return f.denominator.sign(); }, crossing);
}

int later(const Ray& ray, const Crossing& a, const Crossing& b) {
    return decide_on_fractions(
        ray,
        [](const auto& u, const auto& v) { return (u.numerator * v.denominator - v.numerator * u.denominator).sign(); },
        a, b);
}

double time_of(const Ray& ray, const Crossing& crossing) {
    if (crossing.kind == Crossing::Kind::time) return crossing.time;
    BitRange range, direction;
    range.add(ray.origin);
    range.add(crossing.to);
    if (crossing.kind == Crossing::Kind::bisector) range.add(crossing.from);
    direction.add(ray.direction);
    const int unit = range.quantum() - direction.quantum() - 1;
    return decide_on_fractions(
        ray,
        [&](const auto& f) {
            const auto numerator = to_scaled(f.numerator), denominator = to_scaled(f.denominator);
            return std::ldexp(numerator.mantissa / denominator.mantissa,
                              numerator.exponent - denominator.exponent + unit);
        },
        crossing);
}

}  // namespace votess::exact

#include "exact/predicate.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "exact/integer_rows.hpp"
#include "exact/wide_float.hpp"
#include "exact/wide_int.hpp"

namespace votess::exact {
namespace {

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

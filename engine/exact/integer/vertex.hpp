// A vertex in integers of fixed width, for differences below 2^61 quanta.
#pragma once

#include <array>
#include <cstdint>

#include "exact/integer/wide_int.hpp"

namespace votess::exact {

// A plane in quanta: 2 N.X <= S.
struct IntRow {
    std::array<std::int64_t, 3> n;
    Int128 s;
};

// Cramer, as in predicate.cpp: X = V / (2 D). |V| < 2^(4*61+4.2), |D| < 2^(3*61+2.6), |Nd.V - Sd D| < 2^(5*61+6.2).
struct IntVertex {
    std::array<WideInt<4>, 3> v;
    WideInt<3> determinant;

    IntVertex() = default;
    IntVertex(const IntRow& a, const IntRow& b, const IntRow& c) {
        const auto bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
        const auto sa = from_int128<2>(a.s), sb = from_int128<2>(b.s), sc = from_int128<2>(c.s);
        for (int k = 0; k < 3; ++k) v[k] = sa * bc[k] + sb * ca[k] + sc * ab[k];
        determinant = dot(a.n, bc);
    }
    [[nodiscard]] int side(const IntRow& d) const {
        return (dot(d.n, v) - from_int128<2>(d.s) * determinant).sign() * determinant.sign();
    }

private:
    static std::array<WideInt<2>, 3> cross(const IntRow& a, const IntRow& b) {
        auto minor = [&](int i, int j) {
            return from_int128<2>(static_cast<Int128>(a.n[i]) * b.n[j] - static_cast<Int128>(a.n[j]) * b.n[i]);
        };
        return {minor(1, 2), minor(2, 0), minor(0, 1)};
    }
    template <int W>
    static WideInt<W + 1> dot(const std::array<std::int64_t, 3>& n, const std::array<WideInt<W>, 3>& x) {
        return from_int128<1>(n[0]) * x[0] + from_int128<1>(n[1]) * x[1] + from_int128<1>(n[2]) * x[2];
    }
};

}  // namespace votess::exact

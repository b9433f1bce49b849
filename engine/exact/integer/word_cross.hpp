// The signs of determinants of three vectors of 64-bit integers.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "exact/integer/rows.hpp"

namespace votess::exact {

using WordVector = std::array<std::int64_t, 3>;

// The cross product of two vectors below 2^62, for the signs of c.(a x b). In double first, with
//     E = c.(a x b),  A = the same over absolute values,
// and with u = 2^-53 and vectors rounded once, |error of E| <= 8 u A (see orientation.cpp). E is exact when A <= 2^52:
// each value that is not multiplied by 0 is then an integer below 2^53. So it is for vectors across one axis, where
// A = 0, and for those of most lattices. Otherwise integers decide.
class WordCross {
public:
    WordCross() = default;  // contents are undefined
    WordCross(const WordVector& a, const WordVector& b) : a_(a), b_(b) {
        const auto u = rounded(a), v = rounded(b);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = k == 2 ? 0 : k + 1, j = k == 0 ? 2 : k - 1;
            const double plus = u[i] * v[j], minus = u[j] * v[i];
            cross_[k] = plus - minus;
            bound_[k] = std::abs(plus) + std::abs(minus);
        }
    }
    [[nodiscard]] int turn(const WordVector& c) const {
        const auto w = rounded(c);
        const double product = dot(cross_, w);
        const double bound = bound_[0] * std::abs(w[0]) + bound_[1] * std::abs(w[1]) + bound_[2] * std::abs(w[2]);
        if (std::abs(product) > rounding * bound || bound <= exact_limit) return sign_of(product);
        return exact_turn(c);
    }
    [[nodiscard]] bool is_zero() const {
        const auto equal = [this](int i, int j) {
            return static_cast<Int128>(a_[i]) * b_[j] == static_cast<Int128>(a_[j]) * b_[i];
        };
        return equal(0, 1) && equal(1, 2) && equal(2, 0);
    }

private:
    static constexpr double rounding = 10 * 0x1p-53, exact_limit = 0x1p52;  // leave A room for its own rounding

    [[nodiscard]] static std::array<double, 3> rounded(const WordVector& v) {
        return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
    }
    // Below 6 * 2^186 < 2^191.
    [[nodiscard, gnu::noinline]] int exact_turn(const WordVector& c) const {
        const auto wide = [](const WordVector& v) {
            return std::array{from_int128<1>(v[0]), from_int128<1>(v[1]), from_int128<1>(v[2])};
        };
        return dot(wide(c), cross(wide(a_), wide(b_))).sign();
    }

    WordVector a_, b_;
    std::array<double, 3> cross_, bound_;
};

}  // namespace votess::exact

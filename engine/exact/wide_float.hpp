// Floating point of 2367 bits. Even a cell as thin as the smallest subnormal, in a box of order one, keeps a correct
// volume.
#pragma once

#include <algorithm>

#include "exact/integer/wide_int.hpp"
#include "exact/quad.hpp"

namespace votess::exact {

class WideFloat {
public:
    WideFloat(double x = 0);  // NOLINT(google-explicit-constructor): a number as any other

    // integer * 2^exponent, truncated.
    template <int W>
    WideFloat(const WideInt<W>& integer, int exponent) {
        if (integer.zero()) return;
        constexpr int width = std::max(W, limbs);
        const WideInt<width> size = resize<width>(integer.negative() ? -integer : integer);
        const int shift = 64 * width - 1 - bit_length(size);
        const WideInt<width> aligned = shift_left(size, shift);
        std::copy_n(aligned.limb.end() - limbs, limbs, mantissa_.limb.begin());
        if (integer.negative()) mantissa_ = -mantissa_;
        exponent_ = exponent - shift + 64 * (width - limbs);
    }

    explicit operator Quad() const { return ldexp(Quad(mantissa_), exponent_); }
    explicit operator double() const { return static_cast<double>(static_cast<Quad>(*this)); }

    WideFloat operator-() const;
    friend WideFloat operator+(const WideFloat& a, const WideFloat& b);
    friend WideFloat operator-(const WideFloat& a, const WideFloat& b) { return a + -b; }
    friend WideFloat operator*(const WideFloat& a, const WideFloat& b);
    friend WideFloat operator/(const WideFloat& a, const WideFloat& b);  // b is not 0
    friend WideFloat ldexp(WideFloat x, int exponent) {
        x.exponent_ += exponent;
        return x;
    }
    WideFloat& operator+=(const WideFloat& other) { return *this = *this + other; }
    WideFloat& operator-=(const WideFloat& other) { return *this = *this - other; }

private:
    static constexpr int limbs = 37;
    // Rounds down to the leading limbs.
    [[nodiscard]] WideFloat truncated(int kept) const;

    // The number is mantissa * 2^exponent. The mantissa is as long as possible, or 0.
    WideInt<limbs> mantissa_;
    int exponent_ = 0;
};

}  // namespace votess::exact

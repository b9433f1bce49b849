// Integers of any size, for sums and quotients whose width is not known in advance. Slower than WideInt.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "exact/integer/wide_int.hpp"
#include "exact/quad.hpp"

namespace votess::exact {

class BigInt {
public:
    BigInt() = default;
    BigInt(std::int64_t x) {  // NOLINT(google-explicit-constructor): a number as any other
        if (x != 0) limbs_ = {x < 0 ? 0 - static_cast<std::uint64_t>(x) : static_cast<std::uint64_t>(x)};
        negative_ = x < 0;
    }
    template <int W>
    explicit BigInt(const WideInt<W>& x) : negative_(x.negative()) {
        const WideInt<W> size = negative_ ? -x : x;
        limbs_.assign(size.limb.begin(), size.limb.end());
        trim();
    }

    [[nodiscard]] int sign() const { return negative_ ? -1 : limbs_.empty() ? 0 : 1; }
    // Truncates.
    explicit operator Quad() const;

    BigInt operator-() const&;
    friend BigInt operator+(const BigInt& a, const BigInt& b) { return a.sum(b, b.negative_); }
    friend BigInt operator-(const BigInt& a, const BigInt& b) { return a.sum(b, !b.negative_); }
    friend BigInt operator*(const BigInt& a, const BigInt& b);

private:
    // Returns *this plus |b|, or minus that.
    [[nodiscard]] BigInt sum(const BigInt& b, bool b_negative) const;
    void trim() {
        while (!limbs_.empty() && limbs_.back() == 0) limbs_.pop_back();
        if (limbs_.empty()) negative_ = false;
    }

    std::vector<std::uint64_t> limbs_;  // of the absolute value, little endian; the last is not 0
    bool negative_ = false;
};

// A quotient, not reduced. The denominator is positive.
struct Fraction {
    BigInt numerator, denominator = 1;

    Fraction() = default;
    Fraction(BigInt n, BigInt d) : numerator(std::move(n)), denominator(std::move(d)) {
        if (denominator.sign() < 0) numerator = -numerator, denominator = -denominator;
    }
    [[nodiscard]] int sign() const { return numerator.sign(); }
    explicit operator Quad() const {
        return sign() == 0 ? Quad() : static_cast<Quad>(numerator) / static_cast<Quad>(denominator);
    }
    friend Fraction operator+(const Fraction& a, const Fraction& b) {
        return {a.numerator * b.denominator + b.numerator * a.denominator, a.denominator * b.denominator};
    }
    friend Fraction operator-(const Fraction& a, const Fraction& b) {
        return {a.numerator * b.denominator - b.numerator * a.denominator, a.denominator * b.denominator};
    }
    friend Fraction operator*(const Fraction& a, const Fraction& b) {
        return {a.numerator * b.numerator, a.denominator * b.denominator};
    }
    friend bool operator<(const Fraction& a, const Fraction& b) { return (a - b).sign() < 0; }
    friend bool operator==(const Fraction& a, const Fraction& b) { return (a - b).sign() == 0; }
};

}  // namespace votess::exact

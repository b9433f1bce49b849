// Floating point of 128 bits without limits on the exponent, the same on every system. Sums have relative errors below
// 2^-126, products below 2^-124, quotients below 2^-122.
#pragma once

#include <bit>
#include <cmath>
#include <compare>
#include <cstdint>

#include "exact/integer/wide_int.hpp"

namespace votess::exact {

class Quad {
public:
    Quad() = default;
    Quad(double x) {  // NOLINT(google-explicit-constructor): a number as any other
        const auto word = std::bit_cast<std::uint64_t>(x);
        const auto field = static_cast<int>(word >> 52 & 0x7ff);
        std::uint64_t mantissa = word & ((std::uint64_t{1} << 52) - 1);
        if (field != 0) mantissa |= std::uint64_t{1} << 52;
        if (mantissa == 0) return;
        const int zeros = std::countl_zero(mantissa);
        bits_ = {mantissa << zeros, 0, (field == 0 ? 1 : field) - 1075 - zeros - 64, x < 0};
    }
    // Truncates.
    template <int W>
    explicit Quad(const WideInt<W>& integer) : bits_(leading_bits(integer)) {}

    // Rounds to nearest, twice where the result is subnormal.
    explicit operator double() const {
        const auto size = static_cast<double>(bits_.high | static_cast<std::uint64_t>(bits_.low != 0));
        const int exponent = bits_.exponent + 64;
        const bool ordinary = exponent > -1023 && exponent < 960;
        const double x = ordinary ? size * std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52)
                                  : std::ldexp(size, exponent);
        return bits_.negative ? -x : x;
    }

    Quad operator-() const {
        Quad result = *this;
        result.bits_.negative = !bits_.negative && !zero();
        return result;
    }
    friend Quad operator+(const Quad& a, const Quad& b) {
        if (a.zero()) return b;
        if (b.zero()) return a;
        const int exponents = a.bits_.exponent - b.bits_.exponent;
        const bool turned = exponents < 0 || (exponents == 0 && a.mantissa() < b.mantissa());
        const Quad &large = turned ? b : a, &small = turned ? a : b;
        const int gap = std::abs(exponents), exponent = large.bits_.exponent;
        if (gap >= 128) return large;
        const Uint128 shifted = small.mantissa() >> gap;
        if (a.bits_.negative == b.bits_.negative) {
            const Uint128 sum = large.mantissa() + shifted;
            if (sum >= shifted) return {sum, exponent, a.bits_.negative};
            return {sum >> 1 | Uint128{1} << 127, exponent + 1, a.bits_.negative};
        }
        // The bits that were shifted out come back where leading bits cancel: then the gap is at most 1, and the
        // difference is exact.
        const Uint128 lost = gap == 0 ? 0 : small.mantissa() << (128 - gap);
        const Uint128 whole = large.mantissa() - shifted - static_cast<Uint128>(lost != 0), rest = -lost;
        if (whole == 0) return rest == 0 ? Quad() : normal(rest, 0, exponent - 128, large.bits_.negative);
        return normal(whole, rest, exponent, large.bits_.negative);
    }
    friend Quad operator-(const Quad& a, const Quad& b) { return a + -b; }
    // Leaves out the product of the lower halves.
    friend Quad operator*(const Quad& a, const Quad& b) {
        if (a.zero() || b.zero()) return {};
        const LeadingBits &x = a.bits_, &y = b.bits_;
        const Uint128 product = static_cast<Uint128>(x.high) * y.high + (static_cast<Uint128>(x.high) * y.low >> 64) +
                                (static_cast<Uint128>(x.low) * y.high >> 64);
        const auto doubled = static_cast<int>(product >> 127 == 0);  // the top bit is one of two
        return {product << doubled, x.exponent + y.exponent + 128 - doubled, x.negative != y.negative};
    }
    // Returns a/b as a double, within 2^-51. b is not 0.
    friend double ratio(const Quad& a, const Quad& b) {
        const double size = static_cast<double>(a.bits_.high) / static_cast<double>(b.bits_.high);
        const double quotient = a.bits_.negative == b.bits_.negative ? size : -size;
        const int exponent = a.bits_.exponent - b.bits_.exponent;
        if (std::abs(exponent) > 1000) return std::ldexp(quotient, exponent);
        return quotient * std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
    }
    // b is not 0. Two steps of Newton's iteration, from a quotient of 51 bits.
    friend Quad operator/(const Quad& a, const Quad& b) {
        Quad divisor = b;
        divisor.bits_.exponent = -127;  // between 1 and 2
        const Quad inverse = 1 / static_cast<double>(divisor);
        Quad quotient = a * inverse;
        for (int step = 0; step < 2; ++step) quotient += inverse * (a - quotient * divisor);
        return ldexp(quotient, -127 - b.bits_.exponent);
    }
    friend Quad ldexp(Quad x, int exponent) {
        if (!x.zero()) x.bits_.exponent += exponent;
        return x;
    }
    Quad& operator+=(const Quad& other) { return *this = *this + other; }

    friend bool operator==(const Quad&, const Quad&) = default;
    friend std::strong_ordering operator<=>(const Quad& a, const Quad& b) {
        const Quad difference = a - b;
        if (difference.zero()) return std::strong_ordering::equal;
        return difference.bits_.negative ? std::strong_ordering::less : std::strong_ordering::greater;
    }

private:
    // The top bit of the mantissa is set.
    Quad(Uint128 mantissa, int exponent, bool negative)
        : bits_{static_cast<std::uint64_t>(mantissa >> 64), static_cast<std::uint64_t>(mantissa), exponent, negative} {}
    // rest: 128 bits behind those of the mantissa, which is not 0.
    static Quad normal(Uint128 mantissa, Uint128 rest, int exponent, bool negative) {
        const auto high = static_cast<std::uint64_t>(mantissa >> 64);
        const int zeros =
            high != 0 ? std::countl_zero(high) : 64 + std::countl_zero(static_cast<std::uint64_t>(mantissa));
        if (zeros > 0) mantissa = mantissa << zeros | rest >> (128 - zeros);
        return {mantissa, exponent - zeros, negative};
    }
    [[nodiscard]] bool zero() const { return bits_.high == 0; }
    [[nodiscard]] Uint128 mantissa() const { return static_cast<Uint128>(bits_.high) << 64 | bits_.low; }

    LeadingBits bits_;
};

}  // namespace votess::exact

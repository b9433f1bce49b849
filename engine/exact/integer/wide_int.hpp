// Fixed-width two's complement integers of W 64-bit limbs, little endian. Nothing checks for overflow: callers choose W
// from bounds on their operands.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace votess::exact {

using Int128 = __int128;
using Uint128 = unsigned __int128;

template <int W>
struct WideInt {
    std::array<std::uint64_t, W> limb{};

    [[nodiscard]] bool negative() const { return static_cast<std::int64_t>(limb[W - 1]) < 0; }
    [[nodiscard]] bool zero() const {
        std::uint64_t any = 0;
        for (auto l : limb) any |= l;
        return any == 0;
    }
    [[nodiscard]] int sign() const { return negative() ? -1 : (zero() ? 0 : 1); }
};

template <int W>
WideInt<W> from_int128(Int128 value) {
    WideInt<W> r;
    const std::uint64_t fill = value < 0 ? ~0ull : 0ull;
    r.limb[0] = static_cast<std::uint64_t>(value);
    for (int i = 1; i < W; ++i) r.limb[i] = i == 1 ? static_cast<std::uint64_t>(value >> 64) : fill;
    return r;
}

template <int W>
WideInt<W> operator+(const WideInt<W>& a, const WideInt<W>& b) {
    WideInt<W> r;
    Uint128 carry = 0;
    for (int i = 0; i < W; ++i) {
        carry += static_cast<Uint128>(a.limb[i]) + b.limb[i];
        r.limb[i] = static_cast<std::uint64_t>(carry);
        carry >>= 64;
    }
    return r;
}

template <int W>
WideInt<W> operator-(const WideInt<W>& a, const WideInt<W>& b) {
    WideInt<W> r;
    std::uint64_t borrow = 0;
    for (int i = 0; i < W; ++i) {
        const Uint128 d = static_cast<Uint128>(a.limb[i]) - b.limb[i] - borrow;
        r.limb[i] = static_cast<std::uint64_t>(d);
        borrow = static_cast<std::uint64_t>(d >> 64) & 1;
    }
    return r;
}

template <int W>
WideInt<W> operator-(const WideInt<W>& a) {
    return WideInt<W>{} - a;
}

// Returns the full product. Schoolbook on the unsigned limbs, where a negative operand counts 2^(64 W) too much; that
// is subtracted afterwards.
template <int A, int B>
WideInt<A + B> short_product(const WideInt<A>& a, const WideInt<B>& b) {
    WideInt<A + B> r;
    for (int i = 0; i < A; ++i) {
        std::uint64_t carry = 0;
        for (int j = 0; j < B; ++j) {
            const Uint128 t = static_cast<Uint128>(a.limb[i]) * b.limb[j] + r.limb[i + j] + carry;
            r.limb[i + j] = static_cast<std::uint64_t>(t);
            carry = static_cast<std::uint64_t>(t >> 64);
        }
        r.limb[i + B] = carry;
    }
    auto subtract_high = [&r](const auto& x, int from, int count) {
        std::uint64_t borrow = 0;
        for (int i = 0; i < count; ++i) {
            const Uint128 d = static_cast<Uint128>(r.limb[from + i]) - x.limb[i] - borrow;
            r.limb[from + i] = static_cast<std::uint64_t>(d);
            borrow = static_cast<std::uint64_t>(d >> 64) & 1;
        }
    };
    if (a.negative()) subtract_high(b, A, B);
    if (b.negative()) subtract_high(a, B, A);
    return r;
}

// Does the same for wide integers, which mostly have few limbs that are not 0.
template <int A, int B>
[[gnu::noinline]] WideInt<A + B> long_product(const WideInt<A>& a, const WideInt<B>& b) {
    const WideInt<A> u = a.negative() ? -a : a;
    const WideInt<B> v = b.negative() ? -b : b;
    WideInt<A + B> r;
    int first = 0, end = B;
    while (first < B && v.limb[first] == 0) ++first;
    while (end > first && v.limb[end - 1] == 0) --end;
    for (int i = 0; i < A; ++i) {
        if (u.limb[i] == 0) continue;
        std::uint64_t carry = 0;
        for (int j = first; j < end; ++j) {
            const Uint128 t = static_cast<Uint128>(u.limb[i]) * v.limb[j] + r.limb[i + j] + carry;
            r.limb[i + j] = static_cast<std::uint64_t>(t);
            carry = static_cast<std::uint64_t>(t >> 64);
        }
        r.limb[i + end] = carry;
    }
    return a.negative() != b.negative() ? -r : r;
}

template <int A, int B>
WideInt<A + B> operator*(const WideInt<A>& a, const WideInt<B>& b) {
    constexpr int few_limbs = 16;
    if constexpr (A + B <= few_limbs) {
        return short_product(a, b);
    } else {
        return long_product(a, b);
    }
}

// Extends the sign or truncates. A truncated value must fit.
template <int To, int From>
WideInt<To> resize(const WideInt<From>& a) {
    WideInt<To> r;
    const std::uint64_t fill = a.negative() ? ~0ull : 0ull;
    for (int i = 0; i < To; ++i) r.limb[i] = i < From ? a.limb[i] : fill;
    return r;
}

template <int W>
WideInt<W> shift_left(const WideInt<W>& a, int bits) {
    WideInt<W> r;
    const int limbs = bits / 64, rest = bits % 64;
    for (int i = W - 1; i >= limbs; --i) {
        r.limb[i] = a.limb[i - limbs] << rest;
        if (rest != 0 && i > limbs) r.limb[i] |= a.limb[i - limbs - 1] >> (64 - rest);
    }
    return r;
}

template <int W>
int bit_length(const WideInt<W>& a) {
    const WideInt<W> m = a.negative() ? -a : a;
    for (int i = W - 1; i >= 0; --i)
        if (m.limb[i] != 0) return 64 * i + 64 - std::countl_zero(m.limb[i]);
    return 0;
}

// (high * 2^64 + low) * 2^exponent, or minus that. The top bit of `high` is set unless the number is 0.
struct LeadingBits {
    std::uint64_t high = 0, low = 0;
    int exponent = 0;
    bool negative = false;

    friend bool operator==(const LeadingBits&, const LeadingBits&) = default;
};

// Truncates.
template <int W>
LeadingBits leading_bits(const WideInt<W>& a) {
    const bool negative = a.negative();
    const WideInt<W> m = negative ? -a : a;
    int top = W - 1;
    while (top >= 0 && m.limb[top] == 0) --top;
    if (top < 0) return {};
    const int zeros = std::countl_zero(m.limb[top]);
    auto word = [&](int i) { return i >= 0 ? m.limb[i] : 0; };
    auto shifted = [&](int i) { return zeros == 0 ? word(i) : (word(i) << zeros) | (word(i - 1) >> (64 - zeros)); };
    return {shifted(top), shifted(top - 1), 64 * (top - 1) - zeros, negative};
}

// A number is mantissa * 2^exponent.
template <class Real>
struct Scaled {
    Real mantissa = 0;
    int exponent = 0;
};

// The mantissa is in [0.5, 1], or 0.
template <int W>
Scaled<double> to_scaled(const WideInt<W>& a) {
    const LeadingBits bits = leading_bits(a);
    const double r = (static_cast<double>(bits.high) + static_cast<double>(bits.low) * 0x1p-64) * 0x1p-64;
    return {bits.negative ? -r : r, r == 0 ? 0 : bits.exponent + 128};
}

}  // namespace votess::exact

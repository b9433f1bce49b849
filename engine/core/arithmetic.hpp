// Rounded division, and multiplication by powers of two.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <type_traits>

namespace votess {

// Returns length / step, rounded up.
template <std::integral A, std::integral B>
constexpr std::common_type_t<A, B> ceil_div(A length, B step) {
    return length / step + (length % step != 0);
}
// Returns the smallest multiple of step that is not below length.
template <std::integral A, std::integral B>
constexpr std::common_type_t<A, B> round_up(A length, B step) {
    return ceil_div(length, step) * step;
}

// Returns ldexp(value, exponent), without a call for each number.
inline double times_power_of_two(double value, int exponent) {
    constexpr int bias = 1023;
    if (exponent <= -bias || exponent > bias) return std::ldexp(value, exponent);
    return value * std::bit_cast<double>(static_cast<std::uint64_t>(bias + exponent) << 52);
}

}  // namespace votess

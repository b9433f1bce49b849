// Rounded division, multiplication by powers of two, and infinity.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace votess {

template <std::integral A, std::integral B>
constexpr std::common_type_t<A, B> ceil_div(A length, B step) {
    return length / step + (length % step != 0);
}
template <std::integral A, std::integral B>
constexpr std::common_type_t<A, B> round_up(A length, B step) {
    return ceil_div(length, step) * step;
}

inline constexpr int double_bias = 1023;
inline constexpr double infinity = std::numeric_limits<double>::infinity();

// Returns 2^exponent, which must be normal.
constexpr double power_of_two(int exponent) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(double_bias + exponent) << 52);
}
// Returns the smallest e with |x| < 2^e for a normal x.
constexpr int exponent_above(double x) {
    return static_cast<int>((std::bit_cast<std::uint64_t>(x) >> 52) & 0x7ff) - (double_bias - 1);
}
// Returns ldexp(value, exponent), without a call for most numbers.
inline double times_power_of_two(double value, int exponent) {
    if (exponent <= -double_bias || exponent > double_bias) return std::ldexp(value, exponent);
    return value * power_of_two(exponent);
}

}  // namespace votess

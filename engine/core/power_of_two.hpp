// Multiplication by powers of two, where a call of ldexp() for each number takes longer than what is done with it.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace votess {

// Returns ldexp(value, exponent).
inline double times_power_of_two(double value, int exponent) {
    constexpr int bias = 1023;
    if (exponent <= -bias || exponent > bias) return std::ldexp(value, exponent);
    return value * std::bit_cast<double>(static_cast<std::uint64_t>(bias + exponent) << 52);
}

}  // namespace votess

// Pseudo-random numbers.
#pragma once

#include <cstdint>

namespace votess {

// Returns a pseudo-random number, the same on all machines: one step of SplitMix64 (Steele, Lea, Flood 2014).
constexpr std::uint64_t scrambled(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
    x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
    return x ^ (x >> 31);
}

}  // namespace votess

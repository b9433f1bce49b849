// Portable random numbers: the same stream on every platform and standard library, so that a seed names an input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace test {

// xoshiro256** (Blackman, Vigna), seeded by splitmix64.
class Random {
public:
    explicit Random(std::uint64_t seed);

    std::uint64_t next();
    double uniform();                                              // [0, 1), multiples of 2^-53
    double uniform(double lower, double upper);                    // [lower, upper)
    std::uint64_t below(std::uint64_t bound);                      // 0 .. bound-1
    std::int64_t integer(std::int64_t lower, std::int64_t upper);  // both ends included
    bool chance(double probability) { return uniform() < probability; }
    // Sum of twelve uniforms: normal enough for clusters, and free of libm, whose last digit differs by platform.
    double gaussian();

private:
    std::uint64_t state_[4];
};

// A random order of 0 .. n-1.
std::vector<std::size_t> permutation(std::size_t n, Random& random);

}  // namespace test

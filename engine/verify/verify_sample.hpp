// The check of verify() by brute force: cells clipped anew by every seed, without any search structure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "votess/votess.hpp"

namespace votess {

// Relative errors of the volume of one cell and of the sum of all.
struct VolumeTolerance {
    double cell, sum;
};
// Face areas: errors relative to the cell's surface are those of a cell's volume.
inline constexpr VolumeTolerance double_tolerance{1e-10, 1e-9}, single_tolerance{1e-5, 1e-4};

inline const VolumeTolerance& volume_tolerance(const Tessellation& t) {
    return t.stats().precision == Precision::single ? single_tolerance : double_tolerance;
}

// Without a sample of the user's size, cells are tried until they took this much work, counted in distance tests: about
// a second. Being counted and not measured, it gives the same sample on every machine.
inline constexpr double sample_budget = 5e8;
inline constexpr std::size_t min_sample = 64;

// splitmix64 (Steele, Lea, Flood 2014): portable, so that a sample is the same everywhere.
struct SampleRandom {
    std::uint64_t state;
    std::uint64_t next() {
        std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }
};

// "" or one line on the first sampled cell that differs; `sampled` becomes the number of cells that were tried.
std::string check_sample(const Tessellation& t, std::span<const double> points, const VerifyOptions& options,
                         std::size_t& sampled);

}  // namespace votess

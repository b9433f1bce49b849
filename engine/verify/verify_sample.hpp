// The check of verify() by brute force: cells clipped anew by every seed, without any search structure.
#pragma once

#include <cstddef>
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

// "" or one line on the first sampled cell that differs; `sampled` becomes the number of cells that were tried.
std::string check_sample(const Tessellation& t, std::span<const double> points, const VerifyOptions& options,
                         std::size_t& sampled);

}  // namespace votess

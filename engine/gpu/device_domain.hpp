// Which jobs a device clips; of others the exact clipper takes every cell.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gpu/seeds/units.hpp"
#include "input/job.hpp"

namespace votess::gpu {

// A periodic domain on a device: box vectors are whole numbers of units, so that images are exact.
struct PeriodicUnits {
    Box box;  // of seeds and images, in the units of length given; along axes that are not periodic the domain's
    Units units;
    std::array<std::array<std::uint64_t, 3>, 3> vector{};
    std::array<double, 3> lower{}, upper{};  // fractions of the corners of the box
};

// Returns nothing when a vector is no whole number of units, or the domain is so skewed that images are few among many
// shifts.
std::optional<PeriodicUnits> periodic_units(const Job& job);

// Boxes with walls and such periodic domains, with seeds that weigh the same.
bool device_clips(const Job& job);

}  // namespace votess::gpu

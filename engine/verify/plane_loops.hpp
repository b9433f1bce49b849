// Vector loops over the planes of a polytope, for the instructions that the processor has. Results do not depend on the
// instructions.
#pragma once

#include <array>
#include <cstddef>

namespace votess {

// Half-spaces n.x <= d. Arrays are padded to a multiple of plane_lanes by planes that nothing touches.
inline constexpr std::size_t plane_lanes = 4;
struct PlaneArrays {
    const double *nx, *ny, *nz, *d, *length, *size;
    std::size_t padded;
};
struct SureBound {  // d - n.x > slope |n| + constant * size + floor
    double slope, constant, floor;
};
struct Hit {
    int plane = -1;
    double time = 0;
};

struct PlaneLoops {
    // Writes d - n.x for all planes. Returns how many exceed the bound.
    int (*slacks)(const PlaneArrays&, const std::array<double, 3>& x, const SureBound&, double* slack);
    // Returns the plane of least slack / n.along > 0, by rounded numbers; -1 if none has a finite one.
    Hit (*first_hit)(const PlaneArrays&, const double* slack, const std::array<double, 3>& along);
};
const PlaneLoops& plane_loops();

}  // namespace votess

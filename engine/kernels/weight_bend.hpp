// Weights around a home as a quadratic function, so that a window can be chosen where they bend.
#pragma once

#include <string_view>

#include "kernels/star_kernels.hpp"

namespace votess::cpu {

// Next to a WeightTilt: w = base + slope.y + y.bend.y + rho with y = x - origin. The tilt at a place has the slope
// there, and its residuals at another one, n away, differ by n.bend.n and the difference of rho. `least` is that of
// rho.
struct WeightBend {
    double bend[3][3];   // symmetric
    double downward[3];  // -y.bend.y is at most the sum of downward y^2
    double largest;      // of |bend|
    double steepest;     // less than 1: n.bend.n is at most steepest n^2
};

// Returns bit k if a seed in box k may have a plane nearer than `length` to a seed of the box home that is moved by
// half of the slope at its place.
using NearBent = unsigned(const BoxBlock&, const WeightBlock&, const Box& home, const WeightTilt&, const WeightBend&,
                          double length);
NearBent& near_bent(std::string_view instructions);
extern NearBent* const near_bent_avx2;

}  // namespace votess::cpu

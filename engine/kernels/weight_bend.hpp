// Weights around a home as a quadratic function, so that a window can be chosen where they bend.
#pragma once

#include <string_view>

#include "kernels/star_kernels.hpp"

namespace votess::cpu {

// Next to a WeightTilt: w = base + slope.y + y.bend.y + rho with y = x - origin. The tilt at a place has the slope
// there, and its residuals at another one, n away, differ by n.bend.n and the difference of rho. `least` is that of
// rho.
//
// So the plane of a seed n away is n.X = (n.A.n + rho_p - rho_q) / 2 with A = 1 - bend: where rho is small, the diagram
// is a Voronoi diagram with the lengths of A, and cells are as long as those are short.
struct WeightBend {
    double bend[3][3];      // symmetric
    double downward[3];     // -y.bend.y is at most the sum of downward y^2
    double largest;         // of |bend|
    double steepest;        // less than 1: n.bend.n is at most steepest n^2
    double steepest_slope;  // the largest of |slope|
    double radius;          // y.A.y is at most its square for the seeds of the home
};

// For select(): a plane n.X = h counts as h / |n|_G away, with |n|_G^2 = n.G.n. In `metric` are the diagonal of G, and
// twice its elements yz, zx, xy. As a seed's cell is seen with another slope of the weights than the window's, turn.n /
// 2 is added to h.
struct BentLimits : SelectLimits {
    float metric[6], turn[3];
};

// For to_window(): `length` is that of near_bent().
struct BentFrame : WindowFrame {
    const WeightTilt* bent_tilt;
    const WeightBend* bend;
};

struct BentKernels {
    // Returns bit k if a seed in box k may have a plane with h < length |n|_A, for a seed of the home that is moved by
    // half of the slope at its place.
    unsigned (*near_bent)(const BoxBlock&, const WeightBlock&, const WeightTilt&, const WeightBend&, double length);
    // The same as StarKernels::to_window(), with the test of near_bent().
    int (*to_bent_window)(const GroupSource&, const BentFrame&, std::int32_t* const* out, std::int32_t* ids,
                          float* residuals);
    // The same as StarKernels::select().
    bool (*select_bent)(const WindowSeeds&, const std::int32_t* p, float weight, const BentLimits&, CandidatePlanes&);
};
template <class Isa>
inline constexpr BentKernels bent_kernels_of{Isa::near_bent, Isa::to_bent_window, Isa::select_bent};
const BentKernels& bent_kernels(std::string_view instructions);
extern const BentKernels bent_kernels_avx2;

}  // namespace votess::cpu

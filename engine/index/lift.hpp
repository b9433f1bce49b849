// A paraboloid that weights follow. Seeds far outside of the domain have cells inside only if their weights grow with
// the square of their distance: w = k |q - c|^2 + r, with small rests r.
//
// A seed q = p + n cuts the vertex p + Y off the cell of p if |n - Y|^2 - w_q < |Y|^2 - w_p. In terms of the moved
// vertex X = Y + k (p - c) that is
//     (1 - k) |n|^2 - 2 n.X < r_q - r_p.
// The cell lies around p - k (p - c), where X is short. A seed beyond 2 |X| / (1 - k) cuts it only if its rest is
// larger.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "exact/predicate.hpp"

namespace votess::cpu {

struct SortedSeeds;

struct Lift {
    double curvature = 0;  // k; 0 if the weights follow none
    double shrink = 1;     // 1 - k, not rounded
    exact::Point center{};
    std::vector<double> rests;  // of all places, rounded up; else empty

    [[nodiscard]] bool exists() const { return curvature > 0; }
    // Returns a bound on the rest of a seed or a probe.
    [[nodiscard]] double max_rest(const exact::Point& at, double weight) const { return rest(at, weight, 1); }
    [[nodiscard]] double min_rest(const exact::Point& at, double weight) const { return rest(at, weight, -1); }
    // Returns k (p - c): the vector to a seed from the place around which its cell lies.
    [[nodiscard]] exact::Point move(const exact::Point& at) const {
        exact::Point move;
        for (std::size_t k = 0; k < 3; ++k) move[k] = curvature * (at[k] - center[k]);
        return move;
    }

private:
    // sign: in which direction to move the result by more than its rounding.
    [[nodiscard]] double rest(const exact::Point& at, double weight, double sign) const {
        constexpr double rounding = 0x1p-49;
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k) square += (at[k] - center[k]) * (at[k] - center[k]);
        return weight - curvature * square + sign * rounding * (std::abs(weight) + curvature * square);
    }
};

// Fits a paraboloid to the weights by least squares. Returns none if it explains little of them.
Lift fit_lift(const SortedSeeds& seeds);

}  // namespace votess::cpu

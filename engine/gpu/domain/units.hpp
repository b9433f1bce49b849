// Coordinates and weights as whole numbers of units, see COORDINATE_BITS and WEIGHT_BITS in shaders/shared/config.h.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "domain/domain.hpp"
#include "shared/layout.h"

namespace votess::gpu {

// Returns a number of 64 bits as the two words that shaders use.
inline uvec2 words(std::uint64_t value) {
    return {static_cast<std::uint32_t>(value), static_cast<std::uint32_t>(value >> 32)};
}

struct Units {
    int shift = 0;  // coordinate * 2^shift is in units

    // Returns units for the box's longest side. The side itself may overflow, its half does not.
    static Units for_box(const Box& box) {
        double half = 0;
        for (int k = 0; k < 3; ++k) half = std::max(half, box.upper[k] * 0.5 - box.lower[k] * 0.5);
        return {COORDINATE_BITS - 2 - std::ilogb(half)};
    }

    // Returns the value in units, rounded down, modulo 2^64. Sets `lossy` where it rounds.
    [[nodiscard]] std::uint64_t of(double value, bool& lossy) const {
        if (value == 0) return 0;
        int exponent = 0;
        const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(value, &exponent), 53));
        const int n = exponent - 53 + shift;
        if (n >= 64) return 0;
        if (n >= 0) return static_cast<std::uint64_t>(mantissa) << n;
        const int right = std::min(-n, 63);
        const std::int64_t rounded = mantissa >> right;
        lossy = lossy || (-n >= 64 || (rounded << right) != mantissa);
        return static_cast<std::uint64_t>(rounded);
    }
    // Returns a bound of the box in units, rounded down, as a double.
    [[nodiscard]] double floor_of(double value) const {
        const double units = std::floor(std::ldexp(value, shift));
        return units == 0 && value < 0 ? -1 : units;  // all bits may be lost
    }
};

// Returns a box whose faces are moved out, along these axes, to whole numbers of units with few bits. Their distances
// from seeds of a lattice are then small whole numbers too (shaders/clip/exact_side.glsl).
inline Box whole_box(Box box, const std::array<bool, 3>& axes) {
    constexpr int side_bits = 10;
    for (std::size_t k = 0; k < 3; ++k) {
        if (!axes[k]) continue;
        const double step = std::ldexp(1.0, std::ilogb(box.upper[k] - box.lower[k]) - side_bits);
        box.lower[k] = std::floor(box.lower[k] / step) * step;
        box.upper[k] = std::ceil(box.upper[k] / step) * step;
    }
    return box;
}

// The weights of a power diagram.
struct WeightUnits {
    int shift = 0;     // a weight times 2^shift is in units
    int exponent = 0;  // a unit is 2^exponent squared units of length: 0 to 66
    // Seeds with a weight below `least` have no cell in a box of these units of length, and count as the least.
    double least = 0, largest = 0;

    // Returns units for weights between these; a seed with the heaviest exists. Weights are squares of lengths that are
    // `scale` times those of `units`. Returns nothing when doubles of this size are too coarse.
    static std::optional<WeightUnits> of(double lightest, double heaviest, const Units& units, double scale);
    // The same for any weights from `least` to `largest`. Returns nothing too when these differ by more than max_span
    // (units.cpp), at least four times the square of the box's longest side.
    static std::optional<WeightUnits> between(double least, double largest, const Units& units, double scale);
};

// Returns the units of the domain's weights; nothing where there are no weights.
std::optional<WeightUnits> weight_units(const Domain& domain, const Units& units, double scale);

}  // namespace votess::gpu

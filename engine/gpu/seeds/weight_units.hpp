// Weights of a power diagram as whole numbers, see WEIGHT_BITS in shaders/shared/config.h.
#pragma once

#include <cstdint>
#include <optional>

#include "domain/domain.hpp"
#include "gpu/seeds/units.hpp"

namespace votess::gpu {

struct WeightUnits {
    int shift = 0;     // a weight times 2^shift is in units
    int exponent = 0;  // a unit is 2^exponent squared units of length: 0 to 66
    // Those below the least have a cell nowhere in a box of these units of length, and count as the least.
    double least = 0, largest = 0;

    // Makes units for weights between these, of which the heaviest is there. scale is the length that the weights are
    // squares of over the one that `units` are parts of. Returns nothing when doubles as large are too coarse.
    static std::optional<WeightUnits> of(double lightest, double heaviest, const Units& units, double scale);
    // The same for any weights from `least` to `largest`. Returns nothing too when these differ by more than
    // most_span (weight_units.cpp), which is at least four times the square of the box's longest side.
    static std::optional<WeightUnits> between(double least, double largest, const Units& units, double scale);
};

// Those of the domain, all of the same units; nothing too where there are no weights.
std::optional<WeightUnits> weight_units(const Domain& domain, const Units& units, double scale);

}  // namespace votess::gpu

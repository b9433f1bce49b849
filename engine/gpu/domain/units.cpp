#include "gpu/domain/units.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace votess::gpu {
namespace {

// No two places of a box are as far apart, because its sides are below 2^COORDINATE_BITS units.
constexpr double squared_diagonal = 3;          // over 2^(2 COORDINATE_BITS)
constexpr double max_more = 3.5, max_span = 4;  // differences of weights that matter; that floats of searches hold
static_assert(squared_diagonal < max_more && max_more < max_span);

// Returns n so that a weight times 2^n is in squared units.
int squared_units(const Units& units, double scale) {
    return 2 * (units.shift - std::ilogb(scale));
}
// Returns `sides` squares of a side of 2^COORDINATE_BITS units as a weight.
double squares(double sides, int in_squares) {
    return std::ldexp(sides, 2 * COORDINATE_BITS - in_squares);
}

}  // namespace

std::optional<WeightUnits> WeightUnits::of(double lightest, double heaviest, const Units& units, double scale) {
    const double most = squares(max_more, squared_units(units, scale));
    double least = std::max(lightest, heaviest - most);
    // Rounding may have increased it.
    if (least > lightest && heaviest - least < most)
        least = std::nextafter(least, -std::numeric_limits<double>::infinity());
    return between(least, heaviest, units, scale);
}

std::optional<WeightUnits> WeightUnits::between(double least, double largest, const Units& units, double scale) {
    const int finest = squared_units(units, scale);
    const double span = largest - least;
    if (!std::isfinite(span) || !(span <= squares(max_span, finest))) return std::nullopt;
    WeightUnits result;
    result.least = least;
    result.largest = largest;
    result.shift = span > 0 ? std::min(WEIGHT_BITS - 2 - std::ilogb(span), finest) : finest;
    result.exponent = finest - result.shift;
    return result;
}

std::optional<WeightUnits> weight_units(const Domain& domain, const Units& units, double scale) {
    if (!domain.has_weights()) return std::nullopt;
    return WeightUnits::of(domain.min_weight, domain.largest_weight, units, scale);
}

}  // namespace votess::gpu

#include "gpu/seeds/weight_units.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace votess::gpu {
namespace {

// No two places of a box are as far apart: its sides are below 2^COORDINATE_BITS units.
constexpr double squared_diagonal = 3;            // over 2^(2 COORDINATE_BITS)
constexpr double most_more = 3.5, most_span = 4;  // of weights that matter; of floats in searches
static_assert(squared_diagonal < most_more && most_more < most_span);

}  // namespace

std::optional<WeightUnits> WeightUnits::of(double lightest, double heaviest, const Units& units, double scale) {
    const int in_squares = 2 * (units.shift - std::ilogb(scale));  // a weight times 2^in_squares is in squared units
    const auto squares = [&](double sides) { return std::ldexp(sides, 2 * COORDINATE_BITS - in_squares); };
    WeightUnits result;
    result.largest = heaviest;
    result.least = std::max(lightest, heaviest - squares(most_more));
    // Rounding may have moved it up.
    if (result.least > lightest && heaviest - result.least < squares(most_more))
        result.least = std::nextafter(result.least, -std::numeric_limits<double>::infinity());
    const double span = heaviest - result.least;
    if (!(span <= squares(most_span))) return std::nullopt;
    const int finest = in_squares;  // one squared unit
    result.shift = span > 0 ? std::min(WEIGHT_BITS - 2 - std::ilogb(span), finest) : finest;
    result.exponent = in_squares - result.shift;
    return result;
}

std::optional<WeightUnits> weight_units(const Domain& domain, const Units& units, double scale) {
    if (!domain.has_weights()) return std::nullopt;
    return WeightUnits::of(domain.least_weight, domain.largest_weight, units, scale);
}

}  // namespace votess::gpu

// Ranks, which searches compare in a power diagram: |q - p|^2 + w_p - w_q in squared units, see clip/filter.glsl. They
// are right to 3e-6 of |q - p|^2 + |w_p - w_q|: distances to 1e-6, differences of weights to 4e-7, the sum to one
// rounding.
//
// The .comp includes search/distances.glsl and clip/relative_to_seed.glsl, or declares pw, before.
#ifndef VOTESS_SEARCH_POWER_GLSL
#define VOTESS_SEARCH_POWER_GLSL

#include "search/seed_weights.glsl"

float weight_unit;  // of weights, in squared units

void set_weight_unit(int weight_exponent) {
    weight_unit = uintBitsToFloat(uint(127 + weight_exponent) << 23);
}

// Returns how much lighter a seed of weight w is than the cell's.
float rough_lighter_by(uvec2 w) {
    return rough_difference(pw, w) * weight_unit;
}

// Returns the rank. It must be the same in every search of a cell, or a search would find a seed twice or never.
float rank_at(float square, float lighter) {
    precise const float rank = square + lighter;
    return rank;
}

// Returns a lower bound of the ranks that searches find for seeds of a box. Seeds are at least as far away as the box
// and not heavier, and w - 4e-7 |w| grows with w.
float min_rank(float squared_gap, float lighter) {
    return rank_at(squared_gap * box_slack, lighter - 1e-5 * abs(lighter));
}

// Returns a whole number that orders floats as their values do.
uint ordered(float number) {
    const uint bits = floatBitsToUint(number);
    return bits ^ ((bits & 0x80000000u) != 0u ? 0xffffffffu : 0x80000000u);
}
float of_ordered(uint order) {
    return uintBitsToFloat(order ^ ((order & 0x80000000u) != 0u ? 0x80000000u : 0xffffffffu));
}

#endif

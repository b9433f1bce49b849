// The distances that searches compare: squared, in units, right to 8 roundings of float32 of at most 2^-23 each, 1e-6.
#ifndef VOTESS_SEARCH_DISTANCES_GLSL
#define VOTESS_SEARCH_DISTANCES_GLSL

#include "numbers/int64.glsl"
#include "shared/layout.h"

// A box and a seed in it are both right to 1e-6; a seed nearer than `worst` is never in a skipped box.
const float box_slack = 1.0 - 1e-5;
// A seed skipped at a squared distance of d lies at d (1 - 1e-6 - 1.4e-5) or beyond; 1.4e-5 is for high words only.
const float reach_slack = 1.0 - 3e-5;

// High words alone err by less than 2^32 units an axis. That is 1.7e-6 of a distance of 2^52 units or more, 6.7e-6 of a
// quarter of it or more, and twice that of its square. The order of nearer seeds is uncertain, and so is that of a
// whole list whose farthest seed is nearer than 2^52 units.
const float coarse_from = 2.03e31;  // squared, 2^104
const float coarse_order_from = 1.27e30;

float coarse_offset(uint q, uint p) {
    return float(int(q - p)) * 4294967296.0;
}

// Returns the distance of p from the interval [lower, upper].
float gap(uvec2 p, uvec2 lower, uvec2 upper) {
    if (less64(p, lower)) return rough_difference(lower, p);
    if (less64(upper, p)) return rough_difference(p, upper);
    return 0.0;
}

float coarse_gap(uint p, uint lower, uint upper) {
    return 4294967296.0 * (p < lower ? float(lower - p) : (upper < p ? float(p - upper) : 0.0));
}

// Returns the squared radius of a ball with about `count` seeds, from the density of the 64 seeds around it in memory.
// Their box is about twice as large as their share of space.
float expected_reach_in(Node box, int count) {
    // Another order of the products would underflow.
    precise float volume = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const uvec2 from = box.lower[axis], to = box.upper[axis];
        const float side = float(int(to.y - from.y)) * 4294967296.0 + (float(to.x) - float(from.x));  // roughly
        precise const float share_of_box = side * exp2(-COORDINATE_BITS);
        volume *= share_of_box;
    }
    const float radius = pow(volume * float(count) * EXPECTED_REACH, 1.0 / 3.0);
    return max(radius * radius * exp2(2.0 * COORDINATE_BITS), 1.0);
}

#endif

// The distances that searches compare: squared, in units, right to 8 roundings of float32 of 2^-23 each at most, to 1e-6.
// The .comp declares `push`, with lower, upper and bounded, before.
#ifndef VOTESS_SEARCH_DISTANCES_GLSL
#define VOTESS_SEARCH_DISTANCES_GLSL

#include "numbers/int64.glsl"
#include "shared/layout.h"

// A box and a seed in it are both right to 1e-6, and a seed nearer than `worst` is never in a box left out.
const float box_slack = 1.0 - 1e-5;
// A seed left out at a squared distance of d lies at d (1 - 1e-6 - 1.4e-5) or beyond, the latter for high words alone.
const float reach_slack = 1.0 - 3e-5;

// High words alone err by less than 2^32 units an axis: by 1.7e-6 of a distance from 2^52 units on, 6.7e-6 from a
// quarter of it on, twice that of its square. Seeds nearer than that are in no certain order, and a list whose farthest
// seed is nearer than 2^52 units has no certain order at all.
const float coarse_from = 2.03e31;  // squared, 2^104
const float coarse_order_from = 1.27e30;

float coarse_offset(uint q, uint p) {
    return float(int(q - p)) * 4294967296.0;
}

// The distance of p from the interval [lower, upper].
float gap(uvec2 p, uvec2 lower, uvec2 upper) {
    if (less64(p, lower)) return rough_difference(lower, p);
    if (less64(upper, p)) return rough_difference(p, upper);
    return 0.0;
}

float coarse_gap(uint p, uint lower, uint upper) {
    return 4294967296.0 * (p < lower ? float(lower - p) : (upper < p ? float(p - upper) : 0.0));
}

float distance_to_bounds(int axis, uvec2 p) {
    float nearest = UNBOUNDED;
    if ((push.bounded & (1u << axis)) != 0u) {
        const float d = less64(p, push.lower[axis]) ? 0.0 : rough_difference(p, push.lower[axis]);
        nearest = min(nearest, d * d * reach_slack);
    }
    if ((push.bounded & (8u << axis)) != 0u) {
        const float d = less64(push.upper[axis], p) ? 0.0 : rough_difference(push.upper[axis], p);
        nearest = min(nearest, d * d * reach_slack);
    }
    return nearest;
}

// Nothing is known about seeds beyond the bounds. A seed that lies outside has no reach.
float distance_to_bounds(uvec2 x, uvec2 y, uvec2 z) {
    return min(distance_to_bounds(0, x), min(distance_to_bounds(1, y), distance_to_bounds(2, z)));
}

// The squared radius of a ball with about `count` seeds, from the density of the 64 seeds around in memory. Their box is
// about twice as large as their share of space.
float expected_reach_in(Node box, int count) {
    float volume = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const uvec2 from = box.lower[axis], to = box.upper[axis];
        const float side = float(int(to.y - from.y)) * 4294967296.0 + (float(to.x) - float(from.x));  // roughly
        volume *= side * exp2(-COORDINATE_BITS);
    }
    const float radius = pow(volume * float(count) * EXPECTED_REACH, 1.0 / 3.0);
    return max(radius * radius * exp2(2.0 * COORDINATE_BITS), 1.0);
}

#endif

// The bounds within which all seeds are known. The .comp declares `push`, with lower, upper and bounded, before.
#ifndef VOTESS_SEARCH_BOUNDS_GLSL
#define VOTESS_SEARCH_BOUNDS_GLSL

#include "search/distances.glsl"

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

// Returns the squared distance up to which all seeds are known: none are known beyond the bounds. It is 0 for a seed
// outside of them.
float distance_to_bounds(uvec2 x, uvec2 y, uvec2 z) {
    return min(distance_to_bounds(0, x), min(distance_to_bounds(1, y), distance_to_bounds(2, z)));
}

#endif

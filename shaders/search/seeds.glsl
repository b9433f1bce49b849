// Coordinates of the sorted seeds, in units, and their weights (see WEIGHT_BITS). The .comp declares `push`, with
// seed_count, before.
#ifndef VOTESS_SEARCH_SEEDS_GLSL
#define VOTESS_SEARCH_SEEDS_GLSL

#include "shared/interface.h"

layout(std430, binding = BINDING_SEEDS) readonly buffer Seeds { uvec2 seeds[]; };

uvec2 seed_x(uint seed) {
    return seeds[seed];
}
uvec2 seed_y(uint seed) {
    return seeds[push.seed_count + seed];
}
uvec2 seed_z(uint seed) {
    return seeds[2u * push.seed_count + seed];
}
uvec2 seed_weight(uint seed) {
    return seeds[3u * push.seed_count + seed];
}

#endif

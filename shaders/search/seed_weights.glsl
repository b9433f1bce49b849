// The weights of the sorted seeds (see WEIGHT_BITS), and those below each node of the hierarchy. Variant:
// WRITES_NODE_WEIGHTS.
#ifndef VOTESS_SEARCH_SEED_WEIGHTS_GLSL
#define VOTESS_SEARCH_SEED_WEIGHTS_GLSL

#include "numbers/int64.glsl"
#include "numbers/weights.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(std430, binding = BINDING_SEEDS_W) readonly buffer SeedsW { uvec2 seeds_w[]; };
#ifdef WRITES_NODE_WEIGHTS
layout(std430, binding = BINDING_NODE_WEIGHTS) buffer WeightsOfNodes { NodeWeights node_weights[]; };
#else
layout(std430, binding = BINDING_NODE_WEIGHTS) readonly buffer WeightsOfNodes { NodeWeights node_weights[]; };
#endif

// Returns the tilt of a node, in units.
vec3 tilt_of(uint node) {
    return vec3(node_weights[node].tilt[0], node_weights[node].tilt[1], node_weights[node].tilt[2]);
}

#endif

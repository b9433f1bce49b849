// The weights of the sorted seeds, and the largest one below each node of the hierarchy, see WEIGHT_BITS.
#ifndef VOTESS_SEARCH_SEED_WEIGHTS_GLSL
#define VOTESS_SEARCH_SEED_WEIGHTS_GLSL

#include "numbers/int64.glsl"
#include "numbers/weights.glsl"
#include "shared/interface.h"

layout(std430, binding = BINDING_SEEDS_W) readonly buffer SeedsW { uvec2 seeds_w[]; };
layout(std430, binding = BINDING_NODE_WEIGHTS) readonly buffer NodeWeights { uvec2 node_weights[]; };

#endif

// The boxes over groups of sorted seeds, all levels, and in a power diagram the weights below each. Variant:
// WRITES_NODES.
#ifndef VOTESS_SEARCH_NODES_GLSL
#define VOTESS_SEARCH_NODES_GLSL

#include "numbers/weights.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

// Words of four numbers: fewer loads.
#ifdef WRITES_NODES
layout(std430, binding = BINDING_NODES) buffer Nodes { uvec4 node_words[]; };
#else
layout(std430, binding = BINDING_NODES) readonly buffer Nodes { uvec4 node_words[]; };
#endif

const uint words_of_node = 3u + 2u * weighted;

Node node_at(uint node) {
    const uint at = words_of_node * node;
    const uvec4 a = node_words[at], b = node_words[at + 1u], c = node_words[at + 2u];
    return Node(uvec2[3](a.xy, a.zw, b.xy), uvec2[3](b.zw, c.xy, c.zw));
}

NodeWeights weights_at(uint node) {
    const uint at = words_of_node * node + 3u;
    const uvec4 a = node_words[at], b = node_words[at + 1u];
    const vec4 numbers = uintBitsToFloat(b);
    return NodeWeights(a.xy, float[3](uintBitsToFloat(a.z), uintBitsToFloat(a.w), numbers.x), numbers.y, numbers.z,
                       numbers.w);
}

// Returns the tilt of a node, in units.
vec3 tilt_of(uint node) {
    const NodeWeights weights = weights_at(node);
    return vec3(weights.tilt[0], weights.tilt[1], weights.tilt[2]);
}

#ifdef WRITES_NODES
void put_node(uint node, Node box) {
    const uint at = words_of_node * node;
    node_words[at] = uvec4(box.lower[0], box.lower[1]);
    node_words[at + 1u] = uvec4(box.lower[2], box.upper[0]);
    node_words[at + 2u] = uvec4(box.upper[1], box.upper[2]);
}
void put_weights(uint node, NodeWeights weights) {
    const uint at = words_of_node * node + 3u;
    node_words[at] = uvec4(weights.largest, floatBitsToUint(vec2(weights.tilt[0], weights.tilt[1])));
    node_words[at + 1u] = floatBitsToUint(vec4(weights.tilt[2], weights.drop, weights.image_reach, weights.stretch));
}
void put_image_reach(uint node, float reach) {
    node_words[words_of_node * node + 4u].z = floatBitsToUint(reach);
}
void put_stretch(uint node, float stretch) {
    node_words[words_of_node * node + 4u].w = floatBitsToUint(stretch);
}
#endif

#endif

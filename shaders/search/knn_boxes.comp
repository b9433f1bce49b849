// knn: makes one level of the hierarchy, from the seeds or from the level below.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "numbers/weights.glsl"
#include "search/seeds.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { BoxesPush push; };
layout(std430, binding = BINDING_NODES) buffer Nodes { Node nodes[]; };
layout(std430, binding = BINDING_SEEDS_W) readonly buffer SeedsW { uvec2 seeds_w[]; };
layout(std430, binding = BINDING_NODE_WEIGHTS) buffer NodeWeights { uvec2 node_weights[]; };

void main() {
    const uint node = linear_invocation();
    if (node >= push.count) return;
    Node box;
    uvec2 heaviest = uvec2(0);
    for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] = uvec2(NO_COORDINATE);
        box.upper[axis] = uvec2(0);
    }
    if (push.level == 0u) {
        const uint end = min(push.seed_count, (node + 1u) * GROUP_SEEDS);
        for (uint seed = node * GROUP_SEEDS; seed < end; ++seed) {
            const uvec2 p[3] = {seeds_x[seed], seeds_y[seed], seeds_z[seed]};
            if (p[0].y == NO_COORDINATE) continue;
            if (weighted != 0u) heaviest = max64(heaviest, seeds_w[seed]);
            for (int axis = 0; axis < 3; ++axis) {
                box.lower[axis] = min64(box.lower[axis], p[axis]);
                box.upper[axis] = max64(box.upper[axis], p[axis]);
            }
        }
    } else {
        const uint end = min(push.below_count, (node + 1u) * FAN);
        for (uint child = node * FAN; child < end; ++child) {
            const Node c = nodes[push.below_first + child];
            if (weighted != 0u) heaviest = max64(heaviest, node_weights[push.below_first + child]);
            for (int axis = 0; axis < 3; ++axis) {
                box.lower[axis] = min64(box.lower[axis], c.lower[axis]);
                box.upper[axis] = max64(box.upper[axis], c.upper[axis]);
            }
        }
    }
    nodes[push.first + node] = box;
    if (weighted != 0u) node_weights[push.first + node] = heaviest;
}

// sort: puts coordinates into sorted order. Of equal points the one of lowest index stays, in a power diagram the
// heaviest; the others are marked, and put where no search finds them.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "numbers/weights.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { KeyPush push; };
layout(std430, binding = BINDING_POINTS_X) readonly buffer PointsX { uvec2 points_x[]; };
layout(std430, binding = BINDING_POINTS_Y) readonly buffer PointsY { uvec2 points_y[]; };
layout(std430, binding = BINDING_POINTS_Z) readonly buffer PointsZ { uvec2 points_z[]; };
layout(std430, binding = BINDING_KEYS_IN) readonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = BINDING_INDEX_IN) readonly buffer Index { uint index[]; };
layout(std430, binding = BINDING_SEEDS_X) writeonly buffer SeedsX { uvec2 seeds_x[]; };
layout(std430, binding = BINDING_SEEDS_Y) writeonly buffer SeedsY { uvec2 seeds_y[]; };
layout(std430, binding = BINDING_SEEDS_Z) writeonly buffer SeedsZ { uvec2 seeds_z[]; };
layout(std430, binding = BINDING_SEED_INPUT) writeonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_POINTS_W) readonly buffer PointsW { uvec2 points_w[]; };
layout(std430, binding = BINDING_SEEDS_W) writeonly buffer SeedsW { uvec2 seeds_w[]; };
layout(std430, binding = BINDING_RUN_STATE) buffer State { RunState state; };

bool at_same_place(uint a, uint b) {
    return points_x[a] == points_x[b] && points_y[a] == points_y[b] && points_z[a] == points_z[b];
}

// Whether the point, of the lowest index or not, is one that another at its place leaves no cell. In a power diagram the
// heaviest of a place has the cell, of those the first. `unsure` becomes true where rounding may have made them equal.
bool gives_way_to(uint other, uint point, bool first, inout bool unsure) {
    if (weighted == 0u) return true;
    if (points_w[other] != points_w[point]) return less64(points_w[point], points_w[other]);
    unsure = unsure || state.lossy_weights != 0u;
    return !first;
}

void main() {
    const uint seed = linear_invocation();
    if (seed >= push.count) return;
    const uint point = index[seed];
    uvec2 x = points_x[point], y = points_y[point], z = points_z[point];

    // The sort is stable: among equal keys the indices ascend, and what equals this point lies before it.
    bool duplicate = false, unsure = false;
    const bool outside = x.y == NO_COORDINATE;
    const uvec2 key = keys[seed];
    for (uint back = 1u; back <= seed && !duplicate && !outside; ++back) {
        if (keys[seed - back] != key) break;
        if (back > MOST_LOOK_BACK) {
            atomicOr(state.suspects, 1u);
            break;
        }
        const uint other = index[seed - back];
        duplicate = at_same_place(other, point) && gives_way_to(other, point, false, unsure);
    }
    // A heavier one may lie behind it too.
    for (uint on = 1u; weighted != 0u && seed + on < push.count && !duplicate && !outside; ++on) {
        if (keys[seed + on] != key) break;
        if (on > MOST_LOOK_BACK) {
            atomicOr(state.suspects, 1u);
            break;
        }
        const uint other = index[seed + on];
        duplicate = at_same_place(other, point) && gives_way_to(other, point, true, unsure);
    }
    unsure = unsure || (duplicate && (state.lossy & LOSSY_POINTS) != 0u);
    if (unsure) {  // equal in units, perhaps not as given
        atomicOr(state.suspects, 1u);
        duplicate = false;
    }
    if (duplicate) {
        atomicAdd(state.duplicates, 1u);
        x = y = z = uvec2(NO_COORDINATE);
    }
    seeds_x[seed] = x;
    seeds_y[seed] = y;
    seeds_z[seed] = z;
    if (weighted != 0u) seeds_w[seed] = points_w[point];
    seed_input[seed] = duplicate ? point | DUPLICATE_BIT : point;
}

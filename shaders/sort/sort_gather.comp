// sort: moves coordinates into sorted order. Of equal points the one with the lowest index stays, in a power diagram
// the heaviest. The others are marked and moved to where no search finds them; lighter ones go elsewhere than equal
// ones.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "numbers/weights.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { KeyPush push; };
layout(std430, binding = BINDING_KEYS_IN) readonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = BINDING_INDEX_IN) readonly buffer Index { uint index[]; };
layout(std430, binding = BINDING_SEEDS) writeonly buffer Seeds { uvec2 seeds[]; };
layout(std430, binding = BINDING_SEED_INPUT) writeonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_RUN_STATE) buffer State { RunState state; };

#include "upload/points.glsl"

bool at_same_place(uint a, uint b) {
    return point_x(a) == point_x(b) && point_y(a) == point_y(b) && point_z(a) == point_z(b);
}

// The result of comparing a point with others at its place.
bool duplicate = false;  // no cell
bool lighter = false;    // one of them is heavier
bool unsure = false;     // rounding may have made them equal

// Compares with a point before or behind it. In a power diagram the heaviest point of a place has the cell, the first
// of several.
void compare(uint other, uint point, bool is_before) {
    if (!at_same_place(other, point)) return;
    if (weighted == 0u || point_weight(other) == point_weight(point)) {
        unsure = unsure || (weighted != 0u && state.lossy_weights != 0u);
        duplicate = duplicate || is_before;
    } else if (less64(point_weight(point), point_weight(other))) {
        duplicate = lighter = true;
    }
}

void main() {
    const uint seed = linear_invocation();
    if (seed >= push.total) return;
    const uint point = index[seed];
    uvec2 x = point_x(point), y = point_y(point), z = point_z(point);

    // The sort is stable: indices of equal keys ascend, so a point that equals this one lies before it.
    const bool outside = x.y == NO_COORDINATE;
    const uvec2 key = keys[seed];
    for (uint back = 1u; back <= seed && !outside && !(weighted != 0u ? lighter : duplicate); ++back) {
        if (keys[seed - back] != key) break;
        if (back > MAX_LOOK_BACK) {
            atomicOr(state.suspects, 1u);
            break;
        }
        compare(index[seed - back], point, true);
    }
    // A heavier point may also lie behind it.
    for (uint on = 1u; weighted != 0u && seed + on < push.total && !outside && !lighter; ++on) {
        if (keys[seed + on] != key) break;
        if (on > MAX_LOOK_BACK) {
            atomicOr(state.suspects, 1u);
            break;
        }
        compare(index[seed + on], point, false);
    }
    unsure = (unsure && !lighter) || (duplicate && (state.lossy & LOSSY_POINTS) != 0u);
    if (unsure) {  // equal in units, perhaps not as given
        atomicOr(state.suspects, 1u);
        duplicate = false;
    }
    if (duplicate) {
        atomicAdd(state.duplicates, 1u);
        x = z = uvec2(NO_COORDINATE);
        y = lighter ? uvec2(0) : x;
    }
    seeds[seed] = x;
    seeds[push.total + seed] = y;
    seeds[2u * push.total + seed] = z;
    if (weighted != 0u) seeds[3u * push.total + seed] = point_weight(point);
    seed_input[seed] = duplicate ? point | DUPLICATE_BIT : point;
}

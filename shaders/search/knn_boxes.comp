// knn: makes one level of the hierarchy, from the seeds or from the level below. In a power diagram it also finds the
// heaviest seed below each node, and its fit (search/power.glsl): level 1 fits the weights of its seeds by least squares,
// for itself and for its groups. Higher levels take the mean tilt of the level below.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "numbers/weights.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { BoxesPush push; };
layout(std430, binding = BINDING_RUN_STATE) readonly buffer State { RunState state; };

#define WRITES_NODES
#include "search/nodes.glsl"
#include "search/seeds.glsl"

float weight_unit() {
    return uintBitsToFloat(uint(127 + state.weight_exponent) << 23);
}

// Returns the center of a box, rounded down.
uvec2[3] center_of(Node box) {
    bool lost = false;
    uvec2 center[3];
    for (int axis = 0; axis < 3; ++axis)
        center[axis] = add64(box.lower[axis], shift_right64(subtract64(box.upper[axis], box.lower[axis]), 1u, lost));
    return center;
}

vec3 offset_of(uvec2 p[3], uvec2 from[3]) {
    return vec3(rough_difference(p[0], from[0]), rough_difference(p[1], from[1]), rough_difference(p[2], from[2]));
}

vec3 offset_of(uint seed, uvec2 from[3]) {
    return offset_of(uvec2[3](seed_x(seed), seed_y(seed), seed_z(seed)), from);
}

float largest_of(vec3 a) {
    return max(a.x, max(a.y, a.z));
}

// Returns the tilt of the seeds of a box by least squares: half of the gradient of their weights. It is 0 unless the
// differences of weights matter and the tilt explains most of them: the rest must be less than half as large.
vec3 fit_tilt(uint first, uint end, Node box, uvec2 heaviest) {
    const uvec2 center[3] = center_of(box);
    const float side = largest_of(offset_of(box.upper, box.lower)), unit = weight_unit() / (side * side);
    if (!(side > 0.0)) return vec3(0.0);
    // Offsets in sides, weights in squares of them.
    float count = 0.0, sum_w = 0.0, sum_ww = 0.0;
    vec3 sum = vec3(0.0), sum_xw = vec3(0.0);
    mat3 squares = mat3(0.0);
    for (uint seed = first; seed < end; ++seed) {
        if (seed_x(seed).y == NO_COORDINATE) continue;
        const vec3 x = offset_of(seed, center) / side;
        const float w = rough_difference(seed_weight(seed), heaviest) * unit;
        count += 1.0;
        sum += x;
        sum_w += w;
        sum_ww += w * w;
        sum_xw += x * w;
        squares += outerProduct(x, x);
    }
    const float differences = sum_ww - sum_w * sum_w / count;
    const vec3 right = sum_xw - sum * sum_w / count;
    squares -= outerProduct(sum, sum) / count;
    const float ridge = 1.0e-3 * (squares[0][0] + squares[1][1] + squares[2][2]);
    const vec3 slope = inverse(squares + mat3(ridge)) * right;
    const float rest = differences - 2.0 * dot(slope, right) + dot(slope, squares * slope);
    const float min_differences = 4.0e-6 * count;
    const bool is_better = count >= float(MIN_TILTED_SEEDS) && differences > min_differences && rest < 0.25 * differences;
    const float step = exp2(float(TILT_BITS));
    const vec3 fitted = round(0.5 * side / step * slope) * step;
    return is_better && largest_of(abs(fitted)) < exp2(float(MAX_TILT_BITS)) ? fitted : vec3(0.0);
}

// Returns a lower bound of drops of the seeds of a group, for a tilt.
float drop_of_group(uint first, uint end, Node box, uvec2 heaviest, vec3 of_tilt) {
    const uvec2 center[3] = center_of(box);
    float drop = UNBOUNDED;
    for (uint seed = first; seed < end; ++seed) {
        if (seed_x(seed).y == NO_COORDINATE) continue;
        const vec3 along = 2.0 * of_tilt * offset_of(seed, center);
        const float lighter = rough_difference(heaviest, seed_weight(seed)) * weight_unit();
        const float size = lighter + abs(along.x) + abs(along.y) + abs(along.z);
        drop = min(drop, lighter + (along.x + along.y + along.z) - 2.0e-6 * size);
    }
    return drop;
}

// The same for a node, from its children.
float drop_of_node(uint first, uint end, Node box, uvec2 heaviest, vec3 of_tilt) {
    const uvec2 center[3] = center_of(box);
    float drop = UNBOUNDED;
    for (uint child = first; child < end; ++child) {
        const Node below = node_at(child);
        if (below.lower[0].y == NO_COORDINATE) continue;
        const NodeWeights weights = weights_at(child);
        const float drop_below = weights.drop;
        const vec3 off = 2.0 * abs(tilt_of(child) - of_tilt), half_size = 0.5 * offset_of(below.upper, below.lower),
                   between = offset_of(center_of(below), center);
        const vec3 along = 2.0 * of_tilt * between;
        const float lighter = rough_difference(heaviest, weights.largest) * weight_unit();
        const float size = lighter + abs(drop_below) + dot(off, half_size + abs(between)) + dot(abs(along), vec3(1.0));
        drop = min(drop, lighter + drop_below + (along.x + along.y + along.z) - dot(off, half_size) - 2.0e-6 * size);
    }
    return drop;
}

// Returns the stretch of the children of a node of level 2, roughly: searches start with it.
float stretch_of(uint first, uint end, Node box) {
    const uvec2 center[3] = center_of(box);
    vec3 lower = vec3(UNBOUNDED), upper = vec3(-UNBOUNDED), lower_center = lower, upper_center = upper;
    for (uint child = first; child < end; ++child) {
        const Node below = node_at(child);
        if (below.lower[0].y == NO_COORDINATE) continue;
        const vec3 at = offset_of(center_of(below), center), at_center = at - tilt_of(child);
        lower = min(lower, at);
        upper = max(upper, at);
        lower_center = min(lower_center, at_center);
        upper_center = max(upper_center, at_center);
    }
    const vec3 size = upper - lower, ratio = (upper_center - lower_center) / size;
    if (!(min(size.x, min(size.y, size.z)) * 4.0 > largest_of(size))) return 1.0;
    return clamp(pow(ratio.x * ratio.y * ratio.z, 2.0 / 3.0), 0.4, 2.5);
}

void set_weights(uint node, uvec2 largest, vec3 of_tilt, float drop) {
    put_weights(node, NodeWeights(largest, float[3](of_tilt.x, of_tilt.y, of_tilt.z), drop, 0.0, 1.0));
}

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
            const uvec2 p[3] = {seed_x(seed), seed_y(seed), seed_z(seed)};
            if (p[0].y == NO_COORDINATE) continue;
            if (weighted != 0u) heaviest = max64(heaviest, seed_weight(seed));
            for (int axis = 0; axis < 3; ++axis) {
                box.lower[axis] = min64(box.lower[axis], p[axis]);
                box.upper[axis] = max64(box.upper[axis], p[axis]);
            }
        }
    } else {
        const uint end = min(push.below_count, (node + 1u) * FAN);
        for (uint child = node * FAN; child < end; ++child) {
            const Node c = node_at(push.below_first + child);
            if (weighted != 0u) heaviest = max64(heaviest, weights_at(push.below_first + child).largest);
            for (int axis = 0; axis < 3; ++axis) {
                box.lower[axis] = min64(box.lower[axis], c.lower[axis]);
                box.upper[axis] = max64(box.upper[axis], c.upper[axis]);
            }
        }
    }
    put_node(push.first + node, box);
    if (weighted == 0u) return;
    vec3 of_tilt = vec3(0.0);
    float drop = 0.0;
    if (push.level > 0u && box.lower[0].y != NO_COORDINATE) {
        const uint first = push.below_first + node * FAN,
                   end = push.below_first + min(push.below_count, (node + 1u) * FAN);
        if (push.level == 1u) {
            const uint first_seed = node * FAN * GROUP_SEEDS, end_seed = min(push.seed_count, first_seed + FAN * GROUP_SEEDS);
            of_tilt = fit_tilt(first_seed, end_seed, box, heaviest);
            for (uint child = first; child < end; ++child) {
                const Node below = node_at(child);
                if (below.lower[0].y == NO_COORDINATE) continue;
                const uint seed = (child - push.below_first) * GROUP_SEEDS;
                const uvec2 largest = weights_at(child).largest;
                set_weights(child, largest, of_tilt,
                            drop_of_group(seed, min(push.seed_count, seed + GROUP_SEEDS), below, largest, of_tilt));
            }
        } else {
            float count = 0.0;
            for (uint child = first; child < end; ++child) {
                if (node_at(child).lower[0].y == NO_COORDINATE) continue;
                of_tilt += tilt_of(child);
                count += 1.0;
            }
            of_tilt /= count;
            if (push.level == 2u) {
                const float stretch = stretch_of(first, end, box);
                for (uint child = first; child < end; ++child) put_stretch(child, stretch);
            }
        }
        drop = drop_of_node(first, end, box, heaviest, of_tilt);
    }
    set_weights(push.first + node, heaviest, of_tilt, drop);
}

// knn: finds, for each node of level 1 of a power diagram in a periodic box, how far vertices may lie from the centers of
// its cells before images can cut them off that are not among the seeds. It walks through the hierarchy once for each
// shift by one period. Images that are shifted by more are at least a period away, which the heaviest weight bounds.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "invocations/loop_guard.glsl"
#include "numbers/int64.glsl"
#include "search/distances.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { ReachPush push; };
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_RUN_STATE) readonly buffer State { RunState state; };

uvec2 pw;  // the largest weight of the node

#define WRITES_NODES
#include "search/levels.glsl"
#include "search/power.glsl"
#include "search/seeds.glsl"
#include "search/walk.glsl"

const float max_spread = 7.0;  // the key at which the search ends, over the squared radius of a ball with 64 seeds

Node own;           // box of the node's own seeds
vec3 size_of_own;
float lighter_own;  // the most by which one of them is lighter than pw, plus 2 a.(p - m) from the center m of their box
float to_face[6];   // distance of their box from the bounds of the known seeds, lower ones first
float smallest;     // key of all images so far
uint visits = 0u;

vec3 offset_of(uvec2 p[3], uvec2 from[3]) {
    return vec3(rough_difference(p[0], from[0]), rough_difference(p[1], from[1]), rough_difference(p[2], from[2]));
}

// Sets the box and the weights of own seeds. Returns false when there are none.
bool find_own(uint node, out uvec2 lightest) {
    const uint first = node * FAN * GROUP_SEEDS, end = min(push.seed_count, first + FAN * GROUP_SEEDS);
    own = Node(uvec2[3](uvec2(NO_COORDINATE), uvec2(NO_COORDINATE), uvec2(NO_COORDINATE)),
               uvec2[3](uvec2(0), uvec2(0), uvec2(0)));
    lightest = uvec2(NO_COORDINATE);
    for (uint seed = first; seed < end; ++seed) {
        const uvec2 p[3] = {seed_x(seed), seed_y(seed), seed_z(seed)};
        if (p[0].y == NO_COORDINATE || seed_input[seed] >= push.own_count) continue;
        for (int axis = 0; axis < 3; ++axis) {
            own.lower[axis] = min64(own.lower[axis], p[axis]);
            own.upper[axis] = max64(own.upper[axis], p[axis]);
        }
        lightest = min64(lightest, seed_weight(seed));
    }
    if (own.lower[0].y == NO_COORDINATE) return false;
    size_of_own = offset_of(own.upper, own.lower);
    lighter_own = -UNBOUNDED;
    for (uint seed = first; seed < end; ++seed) {
        const uvec2 p[3] = {seed_x(seed), seed_y(seed), seed_z(seed)};
        if (p[0].y == NO_COORDINATE || seed_input[seed] >= push.own_count) continue;
        const vec3 along = twice_tilt * (offset_of(p, own.lower) - 0.5 * size_of_own);
        const float lighter = rough_lighter_by(seed_weight(seed)), size = abs(lighter) + sum_of(abs(twice_tilt) * size_of_own);
        lighter_own = max(lighter_own, lighter + sum_of(along) + 2.0e-6 * size);
    }
    return true;
}

// Returns a lower bound of s (search/power.glsl) for seeds at this distance or beyond, from the heaviest weight.
float smallest_beyond(float distance, float heavier) {
    return distance - heavier / distance - length(twice_tilt) * 1.00001;
}

// Returns whether a box that is shifted may hold an image that is not among the seeds and has a smaller key than others
// so far. It is that of a node, or a seed of weight w.
bool may_be_smaller(uint node, uvec2 lower[3], uvec2 upper[3], uvec2 shift[3], bool is_seed, uvec2 w, out float key) {
    float unknown_from = UNBOUNDED;  // the part of the box that is not known lies beyond a bound
    for (int axis = 0; axis < 3; ++axis) {
        lower[axis] = add64(lower[axis], shift[axis]);
        upper[axis] = add64(upper[axis], shift[axis]);
        if (is_negative(subtract64(lower[axis], push.lower[axis]))) unknown_from = min(unknown_from, to_face[axis]);
        if (is_negative(subtract64(push.upper[axis], upper[axis]))) unknown_from = min(unknown_from, to_face[3 + axis]);
    }
    key = UNBOUNDED;
    if (unknown_from >= UNBOUNDED) return false;
    const vec3 from = offset_of(lower, own.upper), to = offset_of(upper, own.lower);
    // From the center of their box to the image is n, plus at most half of the box.
    const vec3 from_center = from + 0.5 * size_of_own, to_center = to - 0.5 * size_of_own;
    vec3 v = vec3(0.0);
    float c;
    if (is_seed)
        c = seed_lighter(from_center, 0.0, w);
    else
        bound_node(node, from_center, to_center, v, c);
    const float size = abs(lighter_own) + sum_of((abs(twice_tilt) + 2.0 * abs(v)) * (max(abs(from), abs(to)) + size_of_own));
    c -= lighter_own + sum_of(abs(v) * size_of_own) + 1.0e-5 * size;
    key = node_key(from, to, v, c, unknown_from);
    return key < smallest;
}

void visit_group(uint group, uvec2 shift[3]) {
    const uint end = min(push.seed_count, (group + 1u) * GROUP_SEEDS);
    for (uint seed = group * GROUP_SEEDS; seed < end; ++seed) {
        const uvec2 p[3] = {seed_x(seed), seed_y(seed), seed_z(seed)};
        float key;
        if (p[0].y == NO_COORDINATE || seed_input[seed] >= push.own_count) continue;
        if (may_be_smaller(group, p, p, shift, true, seed_weight(seed), key)) smallest = key;
    }
}

void visit_images(uvec2 shift[3]) {
    const uint root_level = push.level_count - 1u;
    Walk walk = Walk(root_level, 0u, root_level, 0u);
    do {
        for (;;) {
            if (++visits > push.max_visits) return;
            const uint n = nodes_below(walk.level) + walk.node;
            const Node box = node_at(n);
            float key;
            if (box.lower[0].y == NO_COORDINATE || !may_be_smaller(n, box.lower, box.upper, shift, false, uvec2(0), key))
                break;
            if (walk.level == 0u) {
                visit_group(walk.node, shift);
                break;
            }
            descend(walk);
        }
    } while (advance(walk));
}

// Returns the smallest s of images that are not among the seeds; at most that at which the search ends.
float find_smallest(uint node) {
    const uint n = nodes_below(1u) + node;
    const NodeWeights weights = weights_at(n);
    pw = weights.largest;
    begin_power(1.0, state, n);
    set_power_slacks(false);
    uvec2 lightest;
    if (!find_own(node, lightest)) return 0.0;
    smallest = max_spread * weights.stretch * expected_reach_in(node_at(n), int(FAN * GROUP_SEEDS));
    const uint root = nodes_below(push.level_count - 1u);
    const float heavier =
        max(rough_difference(weights_at(root).largest, lightest) * weight_unit, 0.0) * 1.00001 + 2.0 * weight_slack;
    float to_unknown = UNBOUNDED, period = UNBOUNDED;
    for (int axis = 0; axis < 3; ++axis) {
        to_face[axis] = to_face[3 + axis] = UNBOUNDED;
        if ((push.bounded & (1u << axis)) != 0u)
            to_face[axis] = max(rough_difference(own.lower[axis], push.lower[axis]), 0.0);
        if ((push.bounded & (8u << axis)) != 0u)
            to_face[3 + axis] = max(rough_difference(push.upper[axis], own.upper[axis]), 0.0);
        to_unknown = min(to_unknown, min(to_face[axis], to_face[3 + axis]));
        if ((push.periodic & (1u << axis)) != 0u) period = min(period, rough_difference(push.side[axis], uvec2(0)));
    }
    if (to_unknown > 0.0) {
        const float s = smallest_beyond(to_unknown * box_slack, heavier);
        if (s > 0.0 && s * s >= smallest) return sqrt(smallest);
    }
    const float twice_shifted = smallest_beyond(period * box_slack, heavier);
    if (!(twice_shifted > 0.0)) return 0.0;
    smallest = min(smallest, twice_shifted * twice_shifted);
    for (uint i = 0u; i < 27u && smallest > 0.0; ++i) {
        const uint steps[3] = {i % 3u, i / 3u % 3u, i / 9u};  // 2: back
        uvec2 shift[3];
        bool is_shift = i != 0u;
        for (int axis = 0; axis < 3; ++axis) {
            shift[axis] = steps[axis] == 0u ? uvec2(0) : (steps[axis] == 1u ? push.side[axis] : negate64(push.side[axis]));
            is_shift = is_shift && (steps[axis] == 0u || (push.periodic & (1u << axis)) != 0u);
        }
        if (is_shift) visit_images(shift);
    }
    return visits > push.max_visits ? 0.0 : sqrt(max(smallest, 0.0));
}

void main() {
    const uint node = linear_invocation();
    if (node >= push.node_count) return;
    float s = find_smallest(node);
    if (loops_were_cut_short(2u + (push.seed_count >> 31))) s = 0.0;
    for (uint group = node * FAN; group < min(nodes_of(0u), (node + 1u) * FAN); ++group)
        put_image_reach(group, 0.49999 * s);
}

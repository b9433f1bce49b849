// Keys, which searches compare in a power diagram. They replace squared distances.
//
// Let a seed at n from the cell's be lighter by w, less the tilt's share: w_p - w_q + 2 a.n (clip/relative_to_seed.glsl).
// Its plane lies at the distance s / 2 of the center, where s = (|n|^2 + w) / |n|, and cuts off only vertices farther
// away. So a cell with vertices within R needs the seeds with s < 2 R. The key is s^2. It is the squared distance where w
// is 0. Where the plane lies behind the center it is |n|^2 + w, which is negative: heavy seeds come first.
//
// A tilt follows weights that vary smoothly. Then w is small for near seeds, and the nearest seeds have the smallest
// keys, as without weights. Each node of the hierarchy has a fit. It bounds the weight of a seed q of the node by that of
// its heaviest, less `drop`, plus 2 g.(q - m), where m is the center of the box. The fit of a group has the tilt of all
// cells of its seeds. g and `drop` are 0 where weights do not vary smoothly.
//
// Keys are lower bounds. Distances are right to 1e-6, differences of weights to 4e-7, products with the tilt to 5e-7, and
// their sum to 3 roundings of its terms. So 4e-6 of the terms are subtracted, and a unit where weights were rounded.
// Coordinates that were rounded change s by 4e-7, because seeds within 2^24 units have the smallest key.
// High words alone err by less than 2^32 units an axis. From 2^50 units on that is 1.4e-5 of |n|^2 and 7e-6 of |n|. Then
// 2.5e-5 of the terms are subtracted, and 2 |a| times 2^32 units an axis. The reach of a list has a slack for |n|.
// The bound of a node subtracts more, so no seed has a smaller key than its node.
//
// The .comp includes search/distances.glsl and clip/relative_to_seed.glsl, or declares pw, before.
#ifndef VOTESS_SEARCH_POWER_GLSL
#define VOTESS_SEARCH_POWER_GLSL

#include "numbers/int64.glsl"
#include "search/nodes.glsl"

const float smallest_key = -UNBOUNDED, largest_key = 2.9e38;  // seeds with larger keys cut nothing within a box

float from_units;   // factor from units of coordinates to lengths of searches, a power of two
float weight_unit;  // of weights, in squared units of length
float weight_slack;
vec3 twice_tilt;
float key_slack, near_square, offset_slack;
bool has_tilt;

// Sets units of length, weight and tilt. node: the group of the cell's seed, or a node above with the same tilt.
void begin_power(float unit_of_length, RunState run, uint node) {
    from_units = 1.0 / unit_of_length;
    weight_unit = uintBitsToFloat(uint(127 + run.weight_exponent) << 23) * (from_units * from_units);
    weight_slack = run.lossy_weights != 0u ? weight_unit : 0.0;
    twice_tilt = tilt_of(node) * (2.0 * from_units);
    has_tilt = any(notEqual(twice_tilt, vec3(0.0)));
}

// Sets the slacks for offsets from all words, or from high words alone.
void set_power_slacks(bool high_words) {
    near_square = exp2(high_words ? 100.0 : 48.0) * (from_units * from_units);
    offset_slack = high_words ? 4294967296.0 * from_units : 0.0;
    key_slack = high_words ? 2.5e-5 : 4.0e-6;
}

// Returns how much lighter a seed of weight w is than the cell's.
float rough_lighter_by(uvec2 w) {
    return rough_difference(pw, w) * weight_unit;
}

float sum_of(vec3 a) {
    precise const float sum = a.x + a.y + a.z;
    return sum;
}

// rank: |n|^2 + w.
float key_of(float square, float rank) {
    precise const float key = rank / square * rank;
    return square < near_square ? smallest_key : (rank < 0.0 ? rank : min(key, largest_key));
}

// Returns a lower bound of w above for a seed at n, where |n|^2 is `square`, less the slack of its key.
float seed_lighter(vec3 n, float square, uvec2 weight) {
    const float by_weight = rough_lighter_by(weight);
    precise float sum = by_weight - key_slack * (square + abs(by_weight)) - weight_slack;
    if (has_tilt) {
        precise const vec3 by_tilt = twice_tilt * n;
        sum += sum_of(by_tilt) - key_slack * sum_of(abs(by_tilt)) - offset_slack * sum_of(abs(twice_tilt));
    }
    return sum;
}

// Returns the key of a seed. It must be the same in every search of a cell, or a search would find a seed twice or never.
float seed_key(float square, float lighter) {
    precise const float rank = square + lighter;
    return key_of(square, rank);
}

// For a node whose box extends from `lower` to `upper` around the cell's seed: outputs v and c so that w >= c - 2 v.n for a
// seed at n. With the node's tilt g, v is g - a. Without a tilt of the cell v is 0, and the heaviest seed is the bound.
void bound_node(uint node, vec3 lower, vec3 upper, out vec3 v, out float c) {
    const NodeWeights weights = weights_at(node);
    const float by_weight = rough_lighter_by(weights.largest), slack = 2.5 * key_slack;
    v = vec3(0.0);
    c = by_weight - slack * abs(by_weight) - weight_slack;
    if (!has_tilt) return;
    const vec3 a = 0.5 * twice_tilt, g = vec3(weights.tilt[0], weights.tilt[1], weights.tilt[2]) * from_units;
    v = g - a;
    const float drop = weights.drop * (from_units * from_units);
    const vec3 reach = max(abs(lower), abs(upper)) + offset_slack / slack * 2.0;
    const float size = abs(by_weight) + abs(drop) + 2.0 * dot(abs(g) + abs(a) + abs(v), reach);
    c = by_weight + drop + dot(g, lower + upper) - slack * size - weight_slack;
}

// Returns a lower bound of the keys of seeds in this box at this distance or beyond, with the bounds above. With
// t = |n - v| and |n| <= t + |v| = u, s is at least (t^2 + c - |v|^2) / u = u - 2 |v| + c / u where that is positive. It
// grows with u where u^2 >= c. Else t^2 + c - |v|^2 is the bound.
float node_key(vec3 lower, vec3 upper, vec3 v, float c, float distance) {
    const vec3 gap = max(max(lower, -upper), vec3(0.0)), from_v = max(max(lower - v, v - upper), vec3(0.0));
    const float slack = 2.5 * key_slack, square = dot(gap, gap) * (1.0 - slack);
    float key = smallest_key;
    if (!has_tilt) {
        const float further = max(max(square, c), distance * distance);
        key = key_of(further, further + c - slack * abs(c));
        key -= slack * abs(key);
    } else {
        const float off = length(v), nearest = max(sqrt(dot(from_v, from_v)) + off, distance);
        const float u = max(nearest, sqrt(max(c, 0.0))), t = nearest - off;
        const float s = u - 2.0 * off + c / u - slack * (u + 2.0 * off + abs(c) / u);
        const float rank = t * t + c - off * off - 2.0 * slack * (nearest * nearest + off * off + abs(c));
        key = s > 0.0 ? min(s * s, largest_key) : min(rank, 0.0);
    }
    return square < near_square ? smallest_key : key;
}

// Returns a whole number that orders floats as their values do.
uint ordered(float number) {
    const uint bits = floatBitsToUint(number);
    return bits ^ ((bits & 0x80000000u) != 0u ? 0xffffffffu : 0x80000000u);
}
float of_ordered(uint order) {
    return uintBitsToFloat(order ^ ((order & 0x80000000u) != 0u ? 0x80000000u : 0xffffffffu));
}

#endif

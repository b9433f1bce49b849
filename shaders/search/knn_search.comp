// knn: lists the nearest seeds of each cell's seed, nearest first, and the distance up to which the list is complete.
//
// The search climbs from the seed's own group to the root, and descends into every box that is nearer than the farthest
// neighbor of interest. Seeds follow a Hilbert curve, so near ones come early. A full store drops its farther half. In
// the end neighbors are sorted by distance into buckets, each a sixteenth of an octave wide; the order within a bucket
// is arbitrary. The first bucket holds all that are nearer.
//
// In a power diagram keys replace squared distances, see search/power.glsl. All keys below 0 are in the first bucket. If
// that alone exceeds the list, its higher half is dropped.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "invocations/loop_guard.glsl"
#include "kept/kept_word.glsl"
#include "numbers/int64.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(constant_id = CONSTANT_K) const int k = 64;
layout(push_constant) uniform Push { KnnPush push; };
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_RUN_STATE) readonly buffer State { RunState state; };

#include "search/bounds.glsl"
#include "search/distances.glsl"
#include "search/hierarchy.glsl"
#include "search/seeds.glsl"
#include "shared/chunk.glsl"

uint self;
uvec2 px, py, pz, pw;

#include "search/power.glsl"

#define BUCKET_OF(d) (max(int((floatBitsToUint(weighted != 0u ? max(d, 0.0) : d) >> BUCKET_SHIFT) - lowest_bucket), 0))

const int store = 2 * k;
const int buckets = 64;

int size = 0;
float distances[store];
uint indices[store];
float worst = UNBOUNDED;  // all visited seeds nearer than this are in the store
bool truncated = false;
bool coarse;  // high words suffice
uint visits = 0u;

int counts[buckets];
int places[buckets];  // not in counts: llvmpipe (Mesa 22.3) mixed up reads and writes of one element in one step
uint lowest_bucket;

float farthest_in_store() {
    float farthest = 0.0;
    for (int i = 0; i < size; ++i) farthest = max(farthest, distances[i]);
    return farthest;
}

// Counts the neighbors in each bucket, up to the farthest one.
void count_by_bucket() {
    const float farthest = farthest_in_store();
    lowest_bucket = (max(floatBitsToUint(farthest), uint(buckets) << BUCKET_SHIFT) >> BUCKET_SHIFT) - uint(buckets - 1);
    for (int b = 0; b < buckets; ++b) counts[b] = 0;
    for (int i = 0; i < size; ++i) ++counts[BUCKET_OF(distances[i])];
}

// Returns the squared distance at which the bucket after b begins.
float bucket_end(int b) {
    return uintBitsToFloat((lowest_bucket + uint(b) + 1u) << BUCKET_SHIFT);
}

// Keeps the nearest k, and all others in the last bucket.
void forget_far_ones() {
    count_by_bucket();
    int kept = 0, b = 0;
    for (; b < buckets && kept < k; ++b) kept += counts[b];
    worst = bucket_end(b - 1);
    kept = 0;
    for (int i = 0; i < size; ++i) {
        const float d = distances[i];
        if (d < worst) {
            indices[kept] = indices[i];
            distances[kept++] = d;
        }
    }
    size = kept;
    if (size == store) {  // all are in one bucket
        truncated = true;
        worst = 0.0;
    }
}

// Keeps those of smallest key: k or a few less.
void forget_large_keys() {
    uint low = 0u, high = ordered(worst);  // at most k are below low, more than k below high
    for (int below = 0; below < k - k / 8 && high - low > 1u;) {
        const uint middle = low + (high - low) / 2u;
        int count = 0;
        for (int i = 0; i < size; ++i) count += ordered(distances[i]) < middle ? 1 : 0;
        if (count > k) {
            high = middle;
        } else {
            low = middle;
            below = count;
        }
    }
    worst = of_ordered(low);
    int kept = 0;
    for (int i = 0; i < size; ++i) {
        const float key = distances[i];
        if (key < worst) {
            indices[kept] = indices[i];
            distances[kept++] = key;
        }
    }
    size = kept;
}

vec3 offset_of(uvec2 x, uvec2 y, uvec2 z) {
    if (coarse) return vec3(coarse_offset(x.y, px.y), coarse_offset(y.y, py.y), coarse_offset(z.y, pz.y));
    return vec3(rough_difference(x, px), rough_difference(y, py), rough_difference(z, pz));
}

void visit_group(uint group) {
    const uint end = min(push.seed_count, (group + 1u) * GROUP_SEEDS);
    for (uint seed = group * GROUP_SEEDS; seed < end; ++seed) {
        if (seed == self || seed_x(seed).y == NO_COORDINATE) continue;
        const vec3 at = offset_of(seed_x(seed), seed_y(seed), seed_z(seed));
        float d = dot(at, at);
        if (weighted != 0u) d = seed_key(d, seed_lighter(at, d, seed_weight(seed)));
        if (!(d < worst)) continue;
        distances[size] = d;
        indices[size++] = seed;
        if (size < store) continue;
        if (weighted != 0u)
            forget_large_keys();
        else
            forget_far_ones();
    }
}

bool is_near(uint level, uint node) {
    const uint n = push.level_first[level] + node;
    const Node box = node_at(n);
    if (box.lower[0].y == NO_COORDINATE) return false;
    if (weighted != 0u) {
        const vec3 lower = offset_of(box.lower[0], box.lower[1], box.lower[2]),
                   upper = offset_of(box.upper[0], box.upper[1], box.upper[2]);
        vec3 v;
        float c;
        bound_node(n, lower, upper, v, c);
        return node_key(lower, upper, v, c, 0.0) < worst;
    }
    float dx, dy, dz;
    if (coarse) {
        dx = coarse_gap(px.y, box.lower[0].y, box.upper[0].y);
        dy = coarse_gap(py.y, box.lower[1].y, box.upper[1].y);
        dz = coarse_gap(pz.y, box.lower[2].y, box.upper[2].y);
    } else {
        dx = gap(px, box.lower[0], box.upper[0]);
        dy = gap(py, box.lower[1], box.upper[1]);
        dz = gap(pz, box.lower[2], box.upper[2]);
    }
    return (dx * dx + dy * dy + dz * dz) * box_slack < worst;
}

// Visits all near boxes below a node.
void explore(uint root_level, uint root) {
    Walk walk = Walk(root_level, root, root_level, root);
    do {
        if (++visits > push.max_visits) return;
        while (is_near(walk.level, walk.node)) {
            if (walk.level == 0u) {
                visit_group(walk.node);
                break;
            }
            descend(walk);
            ++visits;
        }
    } while (advance(walk));
}

void search() {
    uint node = self / GROUP_SEEDS;
    visit_group(node);
    for (uint level = 0u; level + 1u < push.level_count; ++level) {
        const uint first = node & ~(FAN - 1u), end = min(first + FAN, nodes_of(level));
        for (uint sibling = first; sibling < end; ++sibling)
            if (sibling != node) explore(level, sibling);
        node >>= FAN_BITS;
    }
}

float expected_reach() {
    if (push.level_count < 3u) return UNBOUNDED;
    const uint around = push.level_first[1] + self / (GROUP_SEEDS * FAN);
    const float reach = expected_reach_in(node_at(around), k);
    return weighted != 0u ? reach * weights_at(around).stretch : reach;
}

void put_list(uint column, uint lengths, float reach, float bound) {
    of_cells[word_at(WORDS_LIST_LENGTHS, column)] = lengths;
    of_cells[word_at(WORDS_LIST_REACH, column)] = floatBitsToUint(reach);
    of_cells[word_at(WORDS_LIST_BOUND, column)] = floatBitsToUint(bound);
}

void main() {
    const uint column = linear_invocation();
    if (column >= push.cell_count) return;
    if (push.keeps != 0u && is_done(word_of(WORDS_KEPT, column))) return;
    self = push.first_cell + column;
    px = seed_x(self);
    py = seed_y(self);
    pz = seed_z(self);
    if (px.y == NO_COORDINATE || seed_input[self] >= push.own_count) {
        put_list(column, 0u, 0.0, 0.0);
        return;
    }

    if (weighted != 0u) {
        pw = seed_weight(self);
        begin_power(1.0, state, self / GROUP_SEEDS);
    }
    worst = expected_reach();
    bool fine = false;
    for (int attempt = 0; attempt < 4;) {
        coarse = !fine && worst >= coarse_from;
        if (weighted != 0u) set_power_slacks(coarse);
        size = 0;
        search();
        // High words were too coarse: the radius shrank, or all seeds are nearer. Sorted buckets and the list's end are
        // beyond a quarter of the farthest neighbor, where the order is certain again, see coarse_from.
        // Keys are bounds in any case; one below 0 is that of a heavy seed, not of a near one.
        const float needed = weighted != 0u ? worst : min(worst, farthest_in_store());
        if (coarse && needed < coarse_from && (weighted == 0u || needed > 0.0)) {
            fine = true;
            truncated = false;
            worst = max(worst, coarse_from);
            attempt = 0;
            continue;
        }
        if (2 * size >= k || truncated) break;
        ++attempt;
        worst = attempt == 3 ? UNBOUNDED : 4.0 * worst;
    }
    truncated = truncated || visits > push.max_visits;

    // The list holds whole buckets.
    count_by_bucket();
    if (weighted != 0u && counts[0] > k) {
        forget_large_keys();
        count_by_bucket();
    }
    const int in_first_bucket = counts[0];
    int listed = 0, fitting = 0;
    for (; fitting < buckets; ++fitting) {
        places[fitting] = listed;
        listed += counts[fitting];
        if (listed > k) {
            listed = places[fitting];
            break;
        }
    }
    float reach = fitting == buckets ? worst : (fitting == 0 ? 0.0 : bucket_end(fitting - 1));
    if (reach > 0.0) reach *= reach_slack;
    if (worst >= UNBOUNDED && fitting == buckets) reach = UNBOUNDED;
    for (int i = 0; i < size; ++i) {
        const int b = BUCKET_OF(distances[i]);
        if (b >= fitting) continue;
        const int place = places[b];
        of_cells[word_at(WORDS_LIST + uint(place), column)] = indices[i];
        places[b] = place + 1;
    }
    const float bound = distance_to_bounds(px, py, pz);
    const float none = weighted != 0u ? smallest_key : 0.0;
    if (truncated) reach = none;
    if (loops_were_cut_short(2u + (push.seed_count >> 31))) {
        reach = none;
        listed = 0;
    }
    if (weighted == 0u) reach = min(reach, bound);
    put_list(column, uint(listed) | (uint(min(in_first_bucket, listed)) << 16), reach, bound);
}

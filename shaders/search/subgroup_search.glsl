// The search of a subgroup. It stores and sorts all seeds that can cut the cell and whose squared distance is at least
// `done` and below `next`. The lanes test boxes and seeds side by side. They start with the siblings of the seed's
// group and of all boxes that hold it. Children of near boxes follow, GROUP_SEEDS lanes for each, groups of seeds
// before boxes.
//
// The whole store is sorted by unique keys. So the order does not depend on which lane came first, unlike places in
// buckets that atomics assign.
//
// Lengths here are in units of the high words of coordinates, so their differences need no factor.
//
// In a power diagram keys replace squared distances (search/power.glsl), from the smallest possible one, below 0, to one
// that no seed that can cut the cell has. Seeds, and boxes, whose weight keeps them from cutting the cell are skipped. The
// .comp declares `push` (CellsPush) before.
#ifndef VOTESS_SEARCH_SUBGROUP_SEARCH_GLSL
#define VOTESS_SEARCH_SUBGROUP_SEARCH_GLSL

#include "clip/relative_to_seed.glsl"
#include "invocations/subgroup.glsl"
#include "numbers/int64.glsl"
#include "search/distances.glsl"
#include "search/levels.glsl"
#include "search/power.glsl"
#include "search/seeds.glsl"
#include "search/subgroup_state.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(constant_id = CONSTANT_FIRST_COUNT) const int first_count = 48;

const float high_unit = 4294967296.0;  // in units of coordinates
const float low_unit = 1.0 / high_unit;

float done, next;
bool coarse;  // high words suffice
uint candidate_count;
uint visits;
float nearest_beyond;  // lower bound of the squared distance of seeds that this lane skipped as too far
// Bounds, relative to the seed, of all seeds that can cut the cell. Most of a long cell's security sphere lies beyond
// them.
vec3 reach_lower, reach_upper;
uint node_count, group_count;
// In a power diagram:
float reach_radius;    // bound of the distance of all vertices
float first_reach;     // of the first search
float nearest_square;  // of the seeds that this lane tested

const float coarse_search_from = coarse_from / (high_unit * high_unit);
const uint lanes_each = FAN;  // lanes for a box, and for a group, as GROUP_SEEDS == FAN
const uint side_by_side = uint(lanes) / lanes_each;
const uint key_place_mask = SUBGROUP_STORE - 1u;

#define NODE_BITS 28  // a stack's word holds a node's number, and its level above that

// Returns the approximate squared distance in a key of the store.
float distance_of_key(uint key) {
    const uint bits = key & ~key_place_mask;
    return weighted != 0u ? of_ordered(bits) : uintBitsToFloat(bits);
}

uint root_node() {
    return LEVEL_FIRST(push.level_count - 1u);
}

void forget_reach() {
    reach_lower = vec3(-UNBOUNDED);
    reach_upper = vec3(UNBOUNDED);
}

void begin_search() {
    done = 0.0;
    visits = 0u;
    for (uint level = lane; level < push.level_count; level += uint(lanes)) LEVEL_FIRST(level) = nodes_below(level);
    share();
    forget_reach();
    next = UNBOUNDED;
    if (push.level_count >= 3u)
        next = expected_reach_in(node_at(LEVEL_FIRST(1) + self / (GROUP_SEEDS * FAN)), first_count) * (low_unit * low_unit);
    coarse = weighted == 0u && alike(next >= coarse_search_from);
    if (weighted == 0u) return;
    begin_power(high_unit, state, self / GROUP_SEEDS);
    set_power_slacks(false);
    next *= weights_at(LEVEL_FIRST(1) + self / (GROUP_SEEDS * FAN)).stretch;
    nearest_square = UNBOUNDED;
    reach_radius = exp2(float(COORDINATE_BITS + 1)) * low_unit;  // beyond the box
    done = smallest_key;
    first_reach = next;
}

void search_again_finely() {
    coarse = false;
    done = 0.0;
}

// Sets the bounds of the vertex balls: lengths along each axis, down and up. A compared offset is right to 3 of its own
// roundings, 4e-7; with high words alone, to 1 more.
void set_reach(vec3 down, vec3 up, float radius) {
    reach_radius = radius * 1.0001;
    const float slack = coarse ? 8.0 : 0.0;
    reach_lower = -(down * 1.0001 + slack);
    reach_upper = up * 1.0001 + slack;
}

// Sets the range of the next search, outwards, at most to where no seed can cut the cell.
void search_on(float needed) {
    if (weighted != 0u)
        next = min(needed, done + max(abs(done), first_reach) * (candidate_count < 16u ? 3.0 : 1.0));
    else
        next = min(needed, done * (candidate_count < 16u ? 4.0 : 2.0));
    if (!(next < UNBOUNDED)) next = UNBOUNDED;
}

vec3 coarse_offset_of(uvec2 x, uvec2 y, uvec2 z) {
    return vec3(int(x.y - px.y), int(y.y - py.y), int(z.y - pz.y));
}

vec3 fine_offset_of(uvec2 x, uvec2 y, uvec2 z) {
    return vec3(rough_difference(x, px), rough_difference(y, py), rough_difference(z, pz)) * low_unit;
}

// Returns whether a seed may cut the cell. The seed lies between these bounds, with this key or a larger one, and is
// lighter by at least this. For a seed heavier by A, a vertex ball is larger by at most sqrt(A), see set_reach().
bool may_cut(vec3 lower, vec3 upper, float key, float lighter) {
    float further = 0.0;
    bool none = false;
    if (weighted != 0u) {
        further = sqrt(max(-lighter, 0.0)) * 1.0001;
        none = key >= 4.0001 * reach_radius * reach_radius;
    }
    const bool above = any(greaterThan(lower, reach_upper + further)), below = any(lessThan(upper, reach_lower - further));
    return !(none || above || below);
}

// All lanes do the same in the next two functions, without branches.

// Returns whether a box may hold candidates.
bool is_near(uint level, uint node) {
    const uint n = LEVEL_FIRST(level) + node;
    const Node box = node_at(n);
    vec3 lower, upper;
    if (coarse) {
        lower = coarse_offset_of(box.lower[0], box.lower[1], box.lower[2]);
        upper = coarse_offset_of(box.upper[0], box.upper[1], box.upper[2]);
    } else {
        lower = fine_offset_of(box.lower[0], box.lower[1], box.lower[2]);
        upper = fine_offset_of(box.upper[0], box.upper[1], box.upper[2]);
    }
    const vec3 gap = max(max(lower, -upper), vec3(0.0));
    float d = dot(gap, gap) * box_slack, lighter = 0.0;
    if (weighted != 0u) {
        vec3 v;
        float c;
        bound_node(n, lower, upper, v, c);
        d = node_key(lower, upper, v, c, 0.0);
        lighter = c - 2.0 * dot(abs(v), max(abs(lower), abs(upper)));
    }
    const bool full = box.lower[0].y != NO_COORDINATE, may = may_cut(lower, upper, d, lighter), possible = full && may;
    const bool near = d < next;
    nearest_beyond = min(nearest_beyond, possible && !near ? d : UNBOUNDED);
    return possible && near;
}

// Returns whether a seed is a candidate, and outputs its squared distance.
bool is_candidate(uint seed, out float d) {
    const uvec2 x = seed_x(seed), y = seed_y(seed), z = seed_z(seed);
    vec3 at;
    if (coarse)
        at = coarse_offset_of(x, y, z);
    else
        at = fine_offset_of(x, y, z);
    // Must be the same in every search of the cell, or a search would find a seed twice or never.
    precise const float square = at.x * at.x + at.y * at.y + at.z * at.z;
    d = square;
    float lighter = 0.0;
    if (weighted != 0u) {
        lighter = seed_lighter(at, square, seed_weight(seed));
        d = seed_key(square, lighter);
    }
    const bool other = seed != self, there = x.y != NO_COORDINATE, counts = other && there,
               may = may_cut(at, at, d, lighter), possible = counts && may;
    if (weighted != 0u) nearest_square = min(nearest_square, counts ? square : UNBOUNDED);
    const bool near = d < next;
    nearest_beyond = min(nearest_beyond, possible && !near ? d : UNBOUNDED);
    const bool fresh = d >= done;
    return possible && near && fresh;
}

// Pushes near boxes, at most one a lane. Returns false when there are too many.
bool push_near(bool near, uint level, uint node) {
    const bool is_group = level == 0u, is_box = !is_group;
    uint groups, boxes;
    const uint group_place = SUBGROUP_NODES + group_count + rank_among(near && is_group, groups);
    const uint box_place = node_count + rank_among(near && is_box, boxes);
    const bool too_many_boxes = node_count + boxes > SUBGROUP_NODES, too_many_groups = group_count + groups > SUBGROUP_GROUPS;
    if (too_many_boxes || too_many_groups) return false;
    if (near) SCRATCH((is_group ? group_place : box_place)) = (level << NODE_BITS) | node;
    group_count += groups;
    node_count += boxes;
    share();
    return true;
}

// Idle lanes repeat the last item in the next functions.

bool look_into_groups() {
    const uint taken = min(group_count, side_by_side), which = lane / lanes_each;
    group_count -= taken;
    const uint seed = GROUP_STACK(group_count + min(which, taken - 1u)) * GROUP_SEEDS + lane % lanes_each;
    float d;
    const bool near = is_candidate(min(seed, push.seed_count - 1u), d), first_time = which < taken,
               exists = seed < push.seed_count, candidate = near && first_time && exists;
    uint count;
    const uint place = candidate_count + rank_among(candidate, count);
    if (candidate_count + count > SUBGROUP_STORE) return false;
    if (candidate) {
        const uint key = weighted != 0u ? ordered(d) : floatBitsToUint(d);
        CANDIDATE_KEY(place) = (key & ~key_place_mask) | place;
        CANDIDATE_SEED(place) = seed;
    }
    candidate_count += count;
    return true;
}

bool open_boxes() {
    const uint taken = min(node_count, side_by_side), which = lane / lanes_each;
    node_count -= taken;
    visits += taken * FAN;
    const uint parent = NODE_STACK(node_count + min(which, taken - 1u)), level = (parent >> NODE_BITS) - 1u,
               node = (parent & ((1u << NODE_BITS) - 1u)) * FAN + lane % lanes_each, count = nodes_of(level);
    const bool may = is_near(level, min(node, count - 1u)), first_time = which < taken, exists = node < count;
    share();  // read before it is overwritten
    return push_near(may && first_time && exists, level, node);
}

// Returns false when a stack or the store is full.
bool collect() {
    const uint own = self / GROUP_SEEDS, steps = max(push.level_count - 1u, 1u) * FAN;
    visits += steps;
    share();  // the last cut may still read these words
    for (uint first = 0u; first < steps; first += uint(lanes)) {
        const uint step = min(first + lane, steps - 1u), level = step / FAN, count = nodes_of(level),
                   node = (own >> (FAN_BITS * (level + 1u))) * FAN + lane % FAN;
        const bool may = is_near(level, min(node, count - 1u)), first_time = step == first + lane, exists = node < count,
                   other = node != own >> (FAN_BITS * level) || level == 0u;
        if (!push_near(may && first_time && exists && other, level, node)) return false;
    }
    for (;;) {
        if (group_count < side_by_side && node_count > 0u) {
            if (!open_boxes()) return false;
            if (visits > push.max_visits) {
                status = STATUS_CANDIDATES_EXHAUSTED;
                return false;
            }
            continue;
        }
        if (group_count == 0u) return true;
        if (!look_into_groups()) return false;
    }
}

// Sorts the seeds by distance: the place of a key is the number of smaller keys. Returns the key at a rank, which must
// be less than the number of candidates, if that is not 0.
uint sort_candidates(uint rank) {
    // Pads keys to a multiple of eight, because eight are read together.
    const uint eights = (candidate_count + 7u) / 8u;
    if (candidate_count + lane < 8u * eights) CANDIDATE_KEY(candidate_count + lane) = 0xffffffffu;
    share();
    uint key_at_rank = 0xffffffffu;
    [[dont_unroll]] for (uint first = 0u; first < candidate_count; first += uint(lanes)) {
        const uint own = min(first + lane, SUBGROUP_STORE - 1u), key = CANDIDATE_KEY(own);
        uint place = 0u;
        [[dont_unroll]] for (uint i = 0u; i < eights; ++i)
            [[unroll]] for (uint k = 0u; k < 8u; ++k) place += uint(CANDIDATE_KEY(8u * i + k) < key);
        if (first + lane < candidate_count) SORTED_SEED(place) = CANDIDATE_SEED(own);
        if (first + lane < candidate_count && place == rank) key_at_rank = key;
    }
    share();
    return smallest(key_at_rank);
}

// Returns false when the store does not hold them. Then `next` is shorter, or the status says why that cannot help.
bool search() {
    candidate_count = group_count = node_count = 0u;
    nearest_beyond = UNBOUNDED;
    const bool complete = collect();
    if (status != STATUS_CERTIFIED) return false;
    if (complete && weighted != 0u) {
        const float beyond = of_ordered(smallest(ordered(nearest_beyond)));
        done = beyond >= UNBOUNDED ? UNBOUNDED : max(next, beyond);
        return true;
    }
    if (complete) {
        const float beyond = smallest(nearest_beyond);
        done = beyond >= UNBOUNDED ? UNBOUNDED : max(next, beyond * reach_slack);
        return true;
    }
    // The first found are near. After a full store the next search aims at four fifths of first_count.
    const uint key = sort_candidates(candidate_count * uint(first_count) / (5u * SUBGROUP_STORE / 4u));
    const float shorter = candidate_count == 0u ? 0.5 * (max(done, 0.0) + next) : distance_of_key(key);
    if (alike(shorter > done && shorter < next))
        next = shorter;
    else
        status = STATUS_CANDIDATES_EXHAUSTED;
    if (alike(done == 0.0)) coarse = coarse && alike(next >= coarse_search_from);
    return false;
}

#endif

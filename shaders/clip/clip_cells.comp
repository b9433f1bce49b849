// clip: cuts the box around each seed by the bisectors with its neighbors, nearest first, until the security radius
// proves the cell complete. The status of an unproven cell says why. The second tier has larger arrays, and continues
// where the list ends.
//
// Variants: CLIP_FLOAT64 clips in float64, GEOMETRY_FLOAT64 measures in float64, else in sums of two float32;
// DECIDES_TIES uses clip/exact_side.glsl.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shared/layout.h"

layout(push_constant) uniform Push { ClipPush push; };

#include "clip/cell_results.glsl"
#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "clip/unit_of_length.glsl"
#include "clip/walls.glsl"
#include "invocations/index.glsl"
#include "invocations/loop_guard.glsl"
#include "numbers/int64.glsl"
#include "search/seeds.glsl"
#include "shared/interface.h"

layout(constant_id = CONSTANT_TIER) const uint tier = 0u;

#include "clip/first_walls.glsl"
#include "clip/invocation_cell.glsl"
#ifdef DECIDES_TIES
#include "clip/invocation_ties.glsl"
#endif
#include "clip/invocation_results.glsl"
#include "kept/kept_word.glsl"
#include "measure/invocation_measure.glsl"
#include "search/distances.glsl"
#include "search/hierarchy.glsl"
#include "search/power.glsl"

float reach_of_images;  // in a power diagram, in units

void test_next(uint q) {
    const real x = difference(seed_x(q), px), y = difference(seed_y(q), py), z = difference(seed_z(q), pz);
    if (weighted != 0u)
        tested = bisector(x, y, z, lighter_by(seed_weight(q), seed_x(q), seed_y(q), seed_z(q)));
    else
        tested = bisector(x, y, z);
    tested_id = int(q);
}

real security() {
    return security_radius_squared(sqrt(radius_squared), largest_error);
}

real radius() {
    return (sqrt(radius_squared) + largest_error) * real(1.00001);
}

// Returns whether to skip the tested seed. Sets the status when the seed is too near to decide.
bool is_left_out() {
    if (!is_too_near(tested)) return false;
    if (weighted == 0u || !cannot_cut(tested, radius())) status = STATUS_NEEDS_EXACT;
    return true;
}

// Returns whether no unknown seed, at this squared distance in units or beyond, can cut the cell.
bool is_secure_from(float bound) {
    if (bound >= UNBOUNDED) return true;
    if (weighted == 0u) return is_secure(real(bound * scale * scale), security());
    return is_secure(real(bound * scale * scale), cutting_distance_squared(radius() + tilt_length, max_heavier)) ||
           radius() < real(reach_of_images * scale);
}

// Clips by the walls. Each invocation goes to its next wall that cuts, as with neighbors. A wall farther than all
// vertices cuts none off.
void clip_by_walls() {
    measure_radius_and_error();
    const vec3 place = rough_place();
    for (uint next = 0u;;) {
        bool cuts = false;
        for (; next < uint(walls.length()) && !cuts && status == STATUS_CERTIFIED; ++next) {
            const uint w = wall_in_turn(next);
            if (min_wall_distance(w, place) * 0.9999 > float(sqrt(radius_squared) + largest_error)) continue;
            tested = wall_plane(w);
            tested_id = first_wall - int(w);
            cuts = test_plane();
        }
        if (!cuts || status != STATUS_CERTIFIED) return;
        cut();
        if (status != STATUS_CERTIFIED) return;
    }
}

// Clips by the list's neighbors. Neighbors after one lie in its bucket of squared distances or beyond; the first
// `unsorted` have no order. Returns whether the list is complete up to the security radius.
bool clip_by_list(uint column, uint count, uint unsorted, float reach, float bound) {
    uint next = 0u;
    measure_radius_and_error();
    real beyond = security();
    // Walls cut once the box's far corners are gone. In the second tier they cut once the walls' own corners outside of
    // the cell are gone, where more than three walls may meet.
    bool walls_wait = has_walls != 0u;
    uint end = walls_wait && tier == 0u ? min(count, 16u) : count;
    for (;;) {
        // Each invocation goes to its next plane that cuts; then all cut side by side.
        bool cuts = false;
        while (next < end && !cuts && status == STATUS_CERTIFIED) {
            const uint q = word_of(WORDS_LIST + next, column);
            ++next;
            if (next == 16u) measure_radius_and_error();  // the box's far corners are gone
            test_next(q);
            if (is_left_out()) continue;
            if (next > unsorted && key_of(tested, real(-1)) * real(BUCKET_SLACK) >= beyond) {
                next = count;
                break;
            }
            cuts = test_plane();
            beyond = security();
        }
        if (walls_wait && !cuts && status == STATUS_CERTIFIED) {
            walls_wait = false;
            end = count;
            clip_by_walls();
            beyond = security();
            continue;
        }
        if (!cuts || status != STATUS_CERTIFIED) break;
        cut();
        if (status != STATUS_CERTIFIED) break;
    }
    if (status != STATUS_CERTIFIED || (weighted == 0u && reach >= UNBOUNDED)) return true;
    measure_radius_and_error();
    const bool complete = reach >= UNBOUNDED || is_secure(real(reach * scale * scale), security());
    if (weighted != 0u && complete && !is_secure_from(bound)) status = STATUS_CANDIDATES_EXHAUSTED;
    return complete;
}

vec3 offset_of(uvec2 x, uvec2 y, uvec2 z) {
    return vec3(rough_difference(x, px), rough_difference(y, py), rough_difference(z, pz));
}

// Returns false only when no seed in the node's box can cut the cell. A seed cuts a vertex off when it is nearer to it
// than the cell's own seed.
bool in_reach(uint level, uint node, real security) {
    const uint n = push.level_first[level] + node;
    const Node box = node_at(n);
    if (box.lower[0].y == NO_COORDINATE) return false;
    vec3 lower = offset_of(box.lower[0], box.lower[1], box.lower[2]),
         upper = offset_of(box.upper[0], box.upper[1], box.upper[2]);
    vec3 v = vec3(0.0);
    float c = 0.0, key;
    if (weighted != 0u) {
        bound_node(n, lower, upper, v, c);
        key = node_key(lower, upper, v, c, 0.0);
        v *= scale;
        c *= scale * scale;
    } else {
        const vec3 gap = max(max(lower, -upper), vec3(0.0));
        key = dot(gap, gap);
    }
    if (is_secure(real(key * scale * scale), security)) return false;
    lower *= scale;
    upper *= scale;
    // A vertex ball around X + v holds the seeds with |n - X|^2 + c - 2 v.n < |X|^2.
    const real moved = real(1e-6 * length(v));
    for (int first = 0; first < vertex_count; first += side_by_side) {
        bool reached = false;
        for (int i = first; i < first + side_by_side; ++i) {
            const bool near =
                is_in_reach(vertex_x[i] + real(v.x), vertex_y[i] + real(v.y), vertex_z[i] + real(v.z),
                            vertex_error[i] + moved, lower, upper, real(-c));
            reached = reached || (i < vertex_count && near);
        }
        if (reached) return true;
    }
    return false;
}

bool is_plane_of_cell(int id) {
    for (int w = 0; w < plane_words; ++w)
        for (uint rest = planes_used[w]; rest != 0u; rest &= rest - 1u)
            if (plane_id[32 * w + findLSB(rest)] == id) return true;
    return false;
}

// Clips by the seeds of a group that are not nearer than the listed ones.
void clip_by_group(uint group, uint self, real listed) {
    const uint end = min(push.seed_count, (group + 1u) * GROUP_SEEDS);
    bool changed = false;
    for (uint q = group * GROUP_SEEDS; q < end && status == STATUS_CERTIFIED; ++q) {
        if (q == self || seed_x(q).y == NO_COORDINATE) continue;
        test_next(q);
        // A seed that is certainly in the list is done. One that may be in it is a face already, or is tested twice, as are
        // all where the list ends below 0.
        const bool is_listed = listed > real(0) && key_of(tested, real(1)) < listed;
        if (is_listed || is_plane_of_cell(int(q)) || is_left_out()) continue;
        if (test_plane() && status == STATUS_CERTIFIED) {
            cut();
            changed = true;
        }
    }
    if (changed) measure_radius_and_error();
}

// Continues where the list ended: visits all boxes that can hold a seed that cuts the cell, near ones first.
void clip_by_walk(uint self, float reach, float bound) {
    real listed = real(max(reach, 0.0) * scale * scale);
    if (weighted == 0u) listed *= real(0.9999);  // distances in lists are right to 1.4e-5
    uint visits = 0u, node = self / GROUP_SEEDS;
    clip_by_group(node, self, listed);
    for (uint level = 0u; level + 1u < push.level_count; ++level) {
        const uint first = node & ~(FAN - 1u), end = min(first + FAN, nodes_of(level));
        for (uint sibling = first; sibling < end; ++sibling) {
            if (sibling == node) continue;
            Walk walk = Walk(level, sibling, level, sibling);
            do {
                if (++visits > push.max_visits) {
                    status = STATUS_CANDIDATES_EXHAUSTED;
                    return;
                }
                while (status == STATUS_CERTIFIED && in_reach(walk.level, walk.node, security())) {
                    if (walk.level == 0u) {
                        clip_by_group(walk.node, self, listed);
                        break;
                    }
                    descend(walk);
                    ++visits;
                }
                if (status != STATUS_CERTIFIED) return;
            } while (advance(walk));
        }
        node >>= FAN_BITS;
    }
    measure_radius_and_error();
    if (!is_secure_from(bound)) status = STATUS_CANDIDATES_EXHAUSTED;
}

float distance_along_axes(uint q) {
    return max(abs(rough_difference(seed_x(q), px)),
               max(abs(rough_difference(seed_y(q), py)), abs(rough_difference(seed_z(q), pz))));
}

float nearest_of_group(uint self) {
    float nearest = UNBOUNDED;
    const uint first = self & ~(GROUP_SEEDS - 1u), end = min(push.seed_count, first + GROUP_SEEDS);
    for (uint q = first; q < end; ++q)
        if (q != self && seed_x(q).y != NO_COORDINATE) nearest = min(nearest, distance_along_axes(q));
    return nearest;
}

void main() {
    uint slot = linear_invocation(), cell = slot;
    if (tier == 0u) {
        if (slot >= push.cell_count || (push.keeps != 0u && is_done(word_of(WORDS_KEPT, slot)))) return;
    } else {
        if (slot >= chunk.todo_count) return;
        cell = word_of(WORDS_TODO, slot);
        if (push.keeps != 0u) slot = cell;  // rows of earlier rounds stay
    }
    const uint self = push.first_cell + cell;
    px = seed_x(self);
    py = seed_y(self);
    pz = seed_z(self);
    vec3 of_group = vec3(0.0);
    if (weighted != 0u) {
        pw = seed_weight(self);
        of_group = tilt_of(self / GROUP_SEEDS);
        begin_power(1.0, state, self / GROUP_SEEDS);
        set_power_slacks(false);
        reach_of_images = weights_at(self / GROUP_SEEDS).image_reach;
    }
    set_center(of_group);
    if (px.y == NO_COORDINATE || seed_input[self] >= push.own_count) {
        status = (seed_input[self] & DUPLICATE_BIT) != 0u ? STATUS_DUPLICATE : STATUS_OUTSIDE;
        finish(slot, cell, 0u);
        note_for_next_frame(cell);
        return;
    }

    const uint lengths = word_of(WORDS_LIST_LENGTHS, cell), count = lengths & 0xffffu, unsorted = lengths >> 16;
    const float reach = uintBitsToFloat(word_of(WORDS_LIST_REACH, cell)),
                bound = uintBitsToFloat(word_of(WORDS_LIST_BOUND, cell));
    uint exponent = COORDINATE_BITS - 1;
    if (count > 0u || weighted != 0u) {
        float nearest = UNBOUNDED;  // right except for the width of a bucket
        // Any may be the nearest in an order of keys.
        for (uint i = 0u; i < (weighted != 0u ? count : max(unsorted, 1u)); ++i)
            nearest = min(nearest, distance_along_axes(word_of(WORDS_LIST + i, cell)));
        if (weighted != 0u) nearest = min(min(nearest, nearest_of_group(self)), exp2(COORDINATE_BITS - 1));
        exponent = nearest >= 1.0 ? (floatBitsToUint(nearest) >> 23) - 127u : 0u;
    }
    set_unit_of_length(exponent, push.level_first[push.level_count - 1u]);
    prepare_bounds();
    if (state.incomplete != 0u) {
        status = STATUS_CANDIDATES_EXHAUSTED;
    } else if (exponent < SMALLEST_CELL_EXPONENT) {
        status = STATUS_NEEDS_EXACT;
    } else {
        start_cell(real[6](start_wall(0u), start_wall(1u), start_wall(2u), start_wall(3u), start_wall(4u), start_wall(5u)));
        if (status == STATUS_CERTIFIED && !clip_by_list(cell, count, unsorted, reach, bound)) {
            // Heavy seeds may fill the list of a light one.
            if (tier == 0u && weighted == 0u)
                status = STATUS_CANDIDATES_EXHAUSTED;
            else
                clip_by_walk(self, reach, bound);
        }
    }
    finish(slot, cell, exponent);
    note_for_next_frame(cell);
}

// knn and clip in one: a subgroup makes a cell. Its lanes search the hierarchy, test planes and make new vertices side by
// side. They hold the cell's vertices in registers; planes and candidates are in shared memory. The search makes no
// list: it continues outwards until the security radius. The status of an unproven cell says why. The second tier tries
// such cells again, with more planes and vertices, longer searches and, where the device has it, in float64.
//
// Subgroups do not wait for each other. Push constants, shared memory at one index and a subgroup's votes are the same
// in all lanes. Branches on these are uniform; all other branches contain no subgroup operation.
//
// It has the variants of clip_cells.comp, clip/plane_set.glsl and invocations/subgroup.glsl.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#ifndef LANES_OF_WORK_GROUP
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_memory_scope_semantics : require
#endif
#include "shared/layout.h"

layout(push_constant) uniform Push { CellsPush push; };

#include "clip/cell_results.glsl"
#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "clip/unit_of_length.glsl"
#include "clip/walls.glsl"
#include "invocations/index.glsl"
#include "invocations/loop_guard.glsl"
#include "invocations/subgroup.glsl"
#include "kept/kept_column.glsl"
#include "search/seeds.glsl"
#include "search/subgroup_state.glsl"

layout(constant_id = CONSTANT_TIER) const uint tier = 0u;

#include "clip/subgroup_cell.glsl"
#ifdef DECIDES_TIES
#include "clip/subgroup_ties.glsl"
#endif
#include "measure/subgroup_measure.glsl"
#include "search/bounds.glsl"
#include "search/subgroup_search.glsl"

// Leaves the cell to the second tier. It has no vote, for subgroups of another size than this was made for.
void leave(uint cell) {
    put_cell(cell, status, 0u, cell);
}

// Clips by the walls that are not farther than all vertices. Lanes find them side by side.
void clip_by_walls() {
    const vec3 place = rough_place();
    const uint count = uint(walls.length()), each = tests_at_once;
    prepare_bounds();
    for (uint first = 0u; first < count; first += each) {
        const uint w = wall_in_turn(min(first + lane, count - 1u));
        bool near = false;
        if (lane < each && first + lane < count) {
            // Half of the security radius bounds the distance of all vertices.
            near = !(min_wall_distance(w, place) * 1.9999 > float(sqrt(security)));
            if (near) prepare_test(wall_plane(w), first_wall - int(w));
        }
        share();
        for (uint rest = all_bits(near ? 1u << lane : 0u); rest != 0u; rest &= rest - 1u) {
            const uint i = uint(findLSB(rest));
            const Plane p = plane_to_test(i);
            if (!reaches(p)) continue;
            clip_by(p, i);
            if (status != STATUS_CERTIFIED) return;
        }
        share();
    }
}

// Clips by the candidates in the store, nearest first, up to the security radius.
void clip_by_candidates(inout bool walls_wait) {
    prepare_bounds();
    for (uint first = 0u; first < candidate_count; first += tests_at_once) {
        if (has_walls != 0u) {                 // a condition of its own, so that passes without walls have no copy of the cut
            if (walls_wait && first >= 16u) {  // the box's far corners are gone
                walls_wait = false;
                clip_by_walls();
                if (status != STATUS_CERTIFIED) break;
            }
        }
        const uint end = min(candidate_count - first, tests_at_once);
        bool too_near = false;
        real key = real(UNBOUNDED);  // where a lane has no candidate
        if (lane < end) {
            const uint q = SORTED_SEED(first + lane);
            const real x = difference(seed_x(q), px), y = difference(seed_y(q), py), z = difference(seed_z(q), pz);
            Plane p;
            if (weighted != 0u)
                p = bisector(x, y, z, lighter_by(seed_weight(q), seed_x(q), seed_y(q), seed_z(q)));
            else
                p = bisector(x, y, z);
            too_near = is_too_near(p);
            if (weighted != 0u && too_near && cannot_cut(p, radius_of_all)) {
                too_near = false;
                p = Plane(real(0), real(0), real(0), real(1e-30), real(0), real(0));  // cuts nothing
            }
            prepare_test(p, int(q));
            // The order of two seeds is uncertain within the error of their distances, 1e-6 or 1.4e-5
            // (search/distances.glsl), and the six bits that keys lack, 8e-6.
            key = key_of(p, real(-1)) * real(0.9998);
        }
        share();
        if (any_lane(too_near)) {
            status = STATUS_NEEDS_EXACT;
            break;
        }
        uint secure = first_lane(!(key < security));
        for (uint i = 0u; i < secure; ++i) {
            const Plane p = plane_to_test(i);
            if (!reaches(p)) continue;
            clip_by(p, i);
            if (status != STATUS_CERTIFIED) break;
            secure = first_lane(!(key < security));
        }
        if (secure < end || status != STATUS_CERTIFIED) break;
        share();
    }
}

// Takes the cell's unit of length from its nearest neighbor. Returns false when the search was too coarse for it.
bool find_unit(uint nearest_key, inout uint exponent) {
    float nearest = exp2(2.0 * float(COORDINATE_BITS - 1));
    if (candidate_count > 0u) {
        nearest = (weighted != 0u ? smallest(nearest_square) : distance_of_key(nearest_key)) * (high_unit * high_unit);
        if (alike(coarse && nearest < coarse_order_from)) return false;
    }
    exponent = nearest >= 1.0 ? (floatBitsToUint(sqrt(nearest)) >> 23) - 127u : 0u;
    set_unit_of_length(exponent, weighted != 0u ? root_node() : 0u);
    return true;
}

// Returns the factor from squared lengths of searches to squared units of the cell.
float square_scale() {
    return (scale * high_unit) * (scale * high_unit);
}

// In a power diagram: returns whether no unknown seed, at this squared distance of searches or beyond, can cut the cell.
bool is_secure_from(float bound) {
    return bound >= UNBOUNDED ||
           is_secure(real(bound * square_scale()), cutting_distance_squared(radius_of_all + tilt_length, max_heavier)) ||
           radius_of_all < real(weights_at(self / GROUP_SEEDS).image_reach * scale);
}

// Searches and clips in turn, outwards, until it has tested all seeds within the security radius or all that can cut
// the cell. Returns the exponent of the unit of length.
uint make_cell() {
    uint exponent = 0u;
    bool begun = false;  // the cell has its unit of length
    bool walls_wait = has_walls != 0u;
    float bound = UNBOUNDED;
    if (push.bounded != 0u) bound = distance_to_bounds(px, py, pz) * (low_unit * low_unit);
    begin_search();
    for (uint searches = 0u;; ++searches) {
        if (searches == SUBGROUP_SEARCHES) {
            status = STATUS_CANDIDATES_EXHAUSTED;
            break;
        }
        const bool found = search();
        if (status != STATUS_CERTIFIED) break;
        if (!found) continue;  // too many; the next search is shorter
        const uint nearest_key = sort_candidates(0u);
        if (!begun && alike(candidate_count > 0u || done >= UNBOUNDED)) {
            if (!find_unit(nearest_key, exponent)) {
                search_again_finely();
                continue;
            }
            if (alike(exponent < SMALLEST_CELL_EXPONENT))
                status = STATUS_NEEDS_EXACT;
            else
                start_cell();
            if (status != STATUS_CERTIFIED) break;
            begun = true;
        }
        if (candidate_count > 0u) clip_by_candidates(walls_wait);
        if (has_walls != 0u) {
            if (walls_wait && begun && status == STATUS_CERTIFIED) {
                walls_wait = false;
                clip_by_walls();
            }
        }
        if (status != STATUS_CERTIFIED) break;
        if (weighted != 0u) {
            if (alike(done >= UNBOUNDED || (begun && is_secure(real(done * square_scale()), security)))) {
                if (alike(!is_secure_from(bound))) status = STATUS_CANDIDATES_EXHAUSTED;
                break;
            }
        } else {
            const float known = min(done >= UNBOUNDED ? UNBOUNDED : done * reach_slack, bound);
            if (alike(known >= UNBOUNDED || (begun && is_secure(real(known * square_scale()), security)))) break;
            if (alike(known >= bound)) {
                status = STATUS_CANDIDATES_EXHAUSTED;
                break;
            }
        }
        float needed = UNBOUNDED;
        forget_reach();
        if (begun) {
            const float to_search = 1.0 / (scale * high_unit);  // factor from units of the cell, a power of two
            needed = min(float(security) * (to_search * to_search) * 1.001, UNBOUNDED);
            vec3 down, up;
            measure_reach(down, up);
            set_reach(down * to_search, up * to_search, weighted != 0u ? float(radius_of_all) * to_search : 0.0);
        }
        search_on(needed);
    }
    return exponent;
}

// Writes the row and its areas, a lane for each face.
uint write_row(uint slot, PlaneSet used) {
    uint length = 0u;
    for (uint first = 0u; first < max_planes; first += uint(lanes)) {
        const uint p = first + lane;
        const int id = p < max_planes ? id_of(p) : 0;
        const bool listed = p < max_planes && has(used, p) && (id >= 0 || push.walls != 0u);
        uint count;
        const uint at = (length + rank_among(listed, count)) * push.row_stride + slot;
        if (listed) {
            rows[at] = id < 0 ? listed_wall(id) : int(seed_input[id]);
            if (want_geometry == 2u) areas[at] = written(not_negative(area_of(p)));
        }
        length += count;
    }
    return length;
}

// Writes planes and corners for the next frame.
void write_column(uint cell, PlaneSet used) {
    for (uint p = lane; p < max_planes; p += uint(lanes))
        if (has(used, p)) rows[plane_place(cell, rank_in(used, p))] = id_of(p);
    uint corners = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const uint planes = vertex_planes[s];
        uint count;
        const uint at = corners + rank_among(planes != 0u, count);
        if (planes != 0u)
            rows[corner_place(cell, at)] = int(pack_planes(rank_in(used, plane_of(planes, 0)),
                                                           rank_in(used, plane_of(planes, 1)),
                                                           rank_in(used, plane_of(planes, 2))));
        corners += count;
    }
}

void finish(uint slot, uint cell, uint exponent) {
    PlaneSet used = no_planes;
    uint faces = 0u, vertices = 0u, length = 0u;
    share();
    if (status == STATUS_CERTIFIED) {
        used = planes_in_use();
        faces = size_of(used);
        vertices = count_vertices();
        bool fault = false;
        for (uint p = lane; p < max_planes && has_walls != 0u; p += uint(lanes))
            fault = fault || (has(used, p) && is_no_wall(id_of(p)));
        if (any_lane(fault)) status = STATUS_NEEDS_EXACT;
        if (vertices != 2u * faces - 4u) status = STATUS_NEEDS_EXACT;  // Euler, for a simple polytope
    }
    if (want_geometry != 0u && alike(status == STATUS_CERTIFIED)) {
        measure_cell(used, vertices);
        if (any_lane(!is_measured(push.volume_tolerance))) status = STATUS_NEEDS_EXACT;
        uvec2 mine = written(volume);
        if (lane == 1u) mine = written(mass_center.x);
        if (lane == 2u) mine = written(mass_center.y);
        if (lane == 3u) mine = written(mass_center.z);
        if (lane < 4u) geometry[4u * cell + lane] = mine;
    }
#ifdef DECIDES_TIES
    if (alike(status == STATUS_CERTIFIED) && any_lane(met_tie)) keep_true_faces(used, faces, vertices);
#endif
    if (push.neighbors != 0u && alike(status == STATUS_CERTIFIED)) length = write_row(slot, used);
    uint note = KEPT_TRIED;
    if (push.keeps != 0u) {
        bool is_simple = status == STATUS_CERTIFIED && faces <= KEPT_PLANES && vertices <= KEPT_CORNERS;
#ifdef DECIDES_TIES
        is_simple = is_simple && !any_lane(met_tie);
#endif
        if (alike(is_simple)) {
            write_column(cell, used);
            note |= KEPT_MADE | faces | (vertices << KEPT_CORNERS_SHIFT);
        }
    }
    if (any_lane(loops_were_cut_short(2u + (push.cell_count >> 31)))) {
        status = STATUS_CANDIDATES_EXHAUSTED;
        note = KEPT_TRIED;
    }
    if (lane != 0u) return;
    if (push.keeps != 0u)
        of_cells[word_at(WORDS_KEPT, cell)] = tier == 0u ? note : note | KEPT_TRIED_AGAIN;
    if (status != STATUS_CERTIFIED) {
        leave(cell);
        return;
    }
    const uint known = (faces << INFO_FACES_SHIFT) | (vertices << INFO_VERTICES_SHIFT) | (exponent << INFO_EXPONENT_SHIFT);
    put_cell(cell, status | known, length, tier == 0u ? slot : slot | SECOND_TIER_BIT);
}

void main() {
    const uint first = linear_group() * uint(subgroups);
    status = STATUS_CERTIFIED;
    if (!enter_subgroup()) {
        status = STATUS_CANDIDATES_EXHAUSTED;
        const uint cell = first + gl_LocalInvocationID.x;
        if (tier == 0u && gl_LocalInvocationID.x < uint(subgroups) && cell < push.cell_count)
            if (push.keeps == 0u || !is_done(word_of(WORDS_KEPT, cell))) {
                leave(cell);
                if (push.keeps != 0u) of_cells[word_at(WORDS_KEPT, cell)] = KEPT_TRIED;
            }
        return;
    }
    const uint slot = first + SUBGROUP;
    if (alike(slot >= (tier == 0u ? push.cell_count : chunk.todo_count))) return;
    if (tier == 0u && push.keeps != 0u) {
        if (alike(is_done(word_of(WORDS_KEPT, slot)))) return;
    }
    // Lanes address it by their own number. For an address that is the same in all lanes NVK splits the addresses of
    // the buffers, and joins them again in each round of seeds.
    const uint slot_of_lane = first + gl_LocalInvocationID.x / uint(lanes);
    const uint cell = tier == 0u ? slot : word_of(WORDS_TODO, slot),
               own = push.first_cell + (tier == 0u ? slot_of_lane : word_of(WORDS_TODO, slot_of_lane));
    // What lies beyond the bounds stays unknown.
    if (tier != 0u && push.bounded != 0u) {
        if (alike((word_of(WORDS_INFO, cell) & 0xffu) == STATUS_CANDIDATES_EXHAUSTED)) return;
    }
    self = push.first_cell + cell;
    px = from_first_lane(seed_x(own));
    py = from_first_lane(seed_y(own));
    pz = from_first_lane(seed_z(own));
    vec3 of_group = vec3(0.0);
    if (weighted != 0u) {
        pw = seed_weight(self);
        of_group = tilt_of(self / GROUP_SEEDS);
    }
    set_center(of_group);
    uint exponent = 0u;
    if (alike(px.y == NO_COORDINATE || seed_input[self] >= push.own_count))
        status = alike((seed_input[self] & DUPLICATE_BIT) != 0u) ? STATUS_DUPLICATE : STATUS_OUTSIDE;
    else if (alike(state.incomplete != 0u))
        status = STATUS_CANDIDATES_EXHAUSTED;
    else
        exponent = make_cell();
    finish(tier != 0u && push.keeps != 0u ? cell : slot, cell, exponent);  // rows of earlier rounds stay
}

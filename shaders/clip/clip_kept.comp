// kept: tests the cells of the last frame at the places of this one. A cell holds when the filter proves that its
// corners have the right orientation, and that each lies within all other planes. Then the corners are all those of the
// polytope of its planes: they were a closed surface. Nothing else is decided: other cells are made again.
//
// Variants: GEOMETRY_FLOAT64 as in clip_cells.comp. COVERS counts the cells that may be over the place of a seed instead,
// and finds out whether any may be over the seed of an unknown cell (kept/kept_judge.comp).
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "shared/layout.h"

#ifdef COVERS
layout(push_constant) uniform Push { CoverPush push; };
#else
layout(push_constant) uniform Push { ClipPush push; };
#endif

#define READS_ROWS
#include "clip/cell_results.glsl"
#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "clip/unit_of_length.glsl"
#include "clip/walls.glsl"
#include "invocations/index.glsl"
#include "invocations/loop_guard.glsl"
#include "numbers/int64.glsl"
#include "search/nodes.glsl"
#include "search/seeds.glsl"
#include "shared/interface.h"

#include "clip/first_walls.glsl"
#include "kept/kept_column.glsl"

// Returns a plane of the cell.
Plane kept_plane(int id) {
    if (id >= 0) {
        const uint q = uint(id);
        const real x = difference(seed_x(q), px), y = difference(seed_y(q), py), z = difference(seed_z(q), pz);
        if (weighted != 0u) return bisector(x, y, z, lighter_by(seed_weight(q), seed_x(q), seed_y(q), seed_z(q)));
        return bisector(x, y, z);
    }
    if (has_walls != 0u) return wall_plane(uint(first_wall - id));
    const uint wall = uint(-1 - id), axis = wall / 2u;
    const real side = (wall & 1u) != 0u ? real(1) : real(-1), distance = start_wall(wall);
    return Plane(axis == 0u ? side : real(0), axis == 1u ? side : real(0), axis == 2u ? side : real(0), distance, real(1),
                 abs(distance));
}

void set_seed(uint self) {
    px = seed_x(self);
    py = seed_y(self);
    pz = seed_z(self);
    vec3 of_group = vec3(0.0);
    if (weighted != 0u) {
        pw = seed_weight(self);
        of_group = tilt_of(self / GROUP_SEEDS);
    }
    set_center(of_group);
}

#ifdef COVERS

// Returns whether the cell may be over a place, relative to its center in units of the cell.
bool may_be_over(uint cell, uint planes, vec3 at, float error) {
    for (uint i = 0u; i < planes; ++i) {
        const Plane p = kept_plane(rows[plane_place(cell, i)]);
        if (side_of(p, at.x, at.y, at.z) > side_bound(p, error)) return false;
    }
    return true;
}

vec3 vector(int i) {
    return vec3(push.vectors[3 * i], push.vectors[3 * i + 1], push.vectors[3 * i + 2]) * scale;
}

// The same for all images of the cell.
bool any_image_may_be_over(uint cell, uint planes, float reach, uint seed) {
    const vec3 way = vec3(difference(seed_x(seed), cx), difference(seed_y(seed), cy), difference(seed_z(seed), cz));
    const ivec3 steps = ivec3(push.periodic & 1u, (push.periodic >> 1) & 1u, (push.periodic >> 2) & 1u);
    for (int a = -steps.x; a <= steps.x; ++a)
        for (int b = -steps.y; b <= steps.y; ++b)
            for (int c = -steps.z; c <= steps.z; ++c) {
                const vec3 step = float(a) * vector(0) + float(b) * vector(1) + float(c) * vector(2);
                const vec3 at = way - step;
                const float error = 1e-6 * (length(way) + length(vector(0)) + length(vector(1)) + length(vector(2))) +
                                    4.0 * quantum;
                if (!(length(at) > reach * 1.0001 + 2.0 * error) && may_be_over(cell, planes, at, error)) return true;
            }
    return false;
}

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.cell_count) return;
    const uint word = word_of(WORDS_KEPT, cell);
    if ((word & KEPT_HELD) == 0u) return;
    set_seed(cell);
    set_unit_of_length(word_of(WORDS_INFO, cell) >> INFO_EXPONENT_SHIFT, push.root);
    prepare_bounds();
    const float reach = intBitsToFloat(rows[reach_place(cell)]) * scale;
    if (any_image_may_be_over(cell, kept_planes(word), reach, chunk.kept_point)) {
        atomicAdd(chunk.kept_over, 1u);
        chunk.kept_over_cell = cell;
    }
    const uint unknown = min(chunk.unknown_count, uint(KEPT_UNKNOWN));
    bool fault = false;
    for (uint i = 0u; i < unknown && !fault; ++i)
        fault = any_image_may_be_over(cell, kept_planes(word), reach, chunk.unknown[i]);
    if (fault || loops_were_cut_short(2u + (push.cell_count >> 31))) chunk.kept_failed = 1u;
}

#else

const uint tier = 0u;

#include "clip/invocation_cell.glsl"
#include "clip/invocation_results.glsl"
#include "measure/invocation_measure.glsl"
#include "search/distances.glsl"

bool is_on(uint corner, uint plane) {
    return plane_of(corner, 0) == plane || plane_of(corner, 1) == plane || plane_of(corner, 2) == plane;
}

// Sets the status unless all corners certainly lie within the plane, except those on it.
void demand_within(Plane p, uint plane) {
    const real most = side_bound(p, largest_error);
    for (int v = 0; v < vertex_count; ++v) {
        const real side = side_of(p, vertex_x[v], vertex_y[v], vertex_z[v]);
        if (side < -most || is_on(vertex_planes[v], plane)) continue;
        if (!(side < -side_bound(p, vertex_error[v]))) status = STATUS_NEEDS_EXACT;
    }
}

// Makes the planes of the cell, in the unit of its nearest neighbor. Returns the exponent of that unit.
uint restore_planes(uint cell, uint planes) {
    float nearest = UNBOUNDED;
    for (uint i = 0u; i < planes; ++i) {
        const int id = rows[plane_place(cell, i)];
        if (id < 0) continue;
        const uint q = uint(id);
        if (seed_x(q).y == NO_COORDINATE) status = STATUS_NEEDS_EXACT;
        nearest = min(nearest, max(abs(rough_difference(seed_x(q), px)),
                                   max(abs(rough_difference(seed_y(q), py)), abs(rough_difference(seed_z(q), pz)))));
    }
    if (nearest >= UNBOUNDED || nearest < 1.0 || status != STATUS_CERTIFIED) {
        status = STATUS_NEEDS_EXACT;
        return 0u;
    }
    const uint exponent = (floatBitsToUint(nearest) >> 23) - 127u;
    if (exponent < SMALLEST_CELL_EXPONENT) {
        status = STATUS_NEEDS_EXACT;
        return exponent;
    }
    set_unit_of_length(exponent, push.level_first[push.level_count - 1u]);
    prepare_bounds();
    for (int w = 0; w < plane_words; ++w) planes_used[w] = 0u;
    for (uint i = 0u; i < planes; ++i) {
        const int id = rows[plane_place(cell, i)];
        const Plane p = kept_plane(id);
        if (id >= 0 && is_too_near(p)) status = STATUS_NEEDS_EXACT;
        set_plane(i, p, id);
    }
    return exponent;
}

void test_cell(uint cell, uint planes, uint corners) {
    vertex_count = 0;
    largest_error = real(0);
    for (uint v = 0u; v < corners && status == STATUS_CERTIFIED; ++v) {
        const uint corner = uint(rows[corner_place(cell, v)]);
        add_vertex(plane_of(corner, 0), plane_of(corner, 1), plane_of(corner, 2));
    }
    for (uint p = 0u; p < planes && status == STATUS_CERTIFIED; ++p) demand_within(plane_at(p), p);
    // Walls of any direction that the cell does not have. Those of a box need no test: beyond one of them, a line away from
    // it would pass from cell to cell without end.
    if (has_walls != 0u)
        for (uint w = 0u; w < uint(walls.length()) && status == STATUS_CERTIFIED; ++w) {
            bool is_face = false;
            for (uint p = 0u; p < planes; ++p) is_face = is_face || plane_id[p] == first_wall - int(w);
            if (!is_face) demand_within(wall_plane(w), uint(max_planes));
        }
}

// Returns whether the cell holds, and writes it then.
bool keep(uint cell) {
    const uint word = word_of(WORDS_KEPT, cell);
    if (word == 0u) return false;
    const uint planes = kept_planes(word), corners = kept_corners(word);
    set_seed(cell);
    status = px.y == NO_COORDINATE || state.incomplete != 0u || state.suspects != 0u ? STATUS_NEEDS_EXACT : STATUS_CERTIFIED;
    const uint exponent = status == STATUS_CERTIFIED ? restore_planes(cell, planes) : 0u;
    if (status == STATUS_CERTIFIED) test_cell(cell, planes, corners);
    if (status == STATUS_CERTIFIED) {
        measure_radius_and_error();
        const real reach = (sqrt(radius_squared) + largest_error) * real(1.0001);
        const real from_seed = weighted != 0u ? reach + tilt_length : reach;
        if (!(float(from_seed) <= push.kept_reach * scale)) status = STATUS_NEEDS_EXACT;
        rows[reach_place(cell)] = floatBitsToInt(float(reach) / scale);
    }
    if (status == STATUS_CERTIFIED) finish(cell, cell, exponent);
    of_cells[word_at(WORDS_KEPT, cell)] = status == STATUS_CERTIFIED ? word | KEPT_HELD : 0u;
    return status == STATUS_CERTIFIED;
}

// The work-group counts its own pending cells.
shared uint pending;

void main() {
    const bool leads = gl_LocalInvocationIndex == 0u;
    if (leads) pending = 0u;
    barrier();
    const uint cell = linear_invocation();
    const bool is_there = cell < push.cell_count && seed_input[cell] < push.own_count && seed_x(cell).y != NO_COORDINATE;
    if (cell < push.cell_count && !keep(cell) && is_there) atomicAdd(pending, 1u);
    barrier();
    if (leads && pending > 0u) atomicAdd(chunk.kept_pending, pending);
}

#endif

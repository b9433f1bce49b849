// One Voronoi cell, made by a subgroup. Each lane holds some of the vertices; the planes are in shared memory.
// A cut lists the killed vertices. Each lane takes a plane, and finds its edge on the horizon, the ring around the killed
// vertices, from those of them that lie on the plane.
// The new plane and each edge of the horizon make a new vertex, in a free slot.
// Euler's formula and the security radius certify the cell; otherwise the status says why not.
// A free slot is a vertex at the seed itself, which a plane cuts off only in a power diagram. The .comp declares
// `push`, with extent and bounded, before.
#ifndef VOTESS_CLIP_SUBGROUP_CELL_GLSL
#define VOTESS_CLIP_SUBGROUP_CELL_GLSL

#ifdef DECIDES_TIES
#include "clip/exact_side.glsl"
#endif
#include "clip/filter.glsl"
#include "clip/first_walls.glsl"
#include "clip/relative_to_seed.glsl"
#include "invocations/subgroup.glsl"
#include "search/subgroup_state.glsl"
#include "shared/interface.h"

layout(constant_id = CONSTANT_MAX_VERTICES) const int max_vertices = 64;

const int slots = (max_vertices + lanes - 1) / lanes;  // vertices of a lane
const int planes_of_lane = (SUBGROUP_PLANES + lanes - 1) / lanes;
const uint all_planes = 0xffffffffu >> (32 - SUBGROUP_PLANES);

real vertex_x[slots], vertex_y[slots], vertex_z[slots];
real vertex_norm[slots], vertex_error[slots];
uint vertex_planes[slots];     // 0 where there is no vertex
bool killed[slots];
uint free_planes;              // planes not in use
real security;                 // squared radius; in a power diagram a key
real radius_of_all;            // in a power diagram, a bound of the distance of all vertices
#ifdef DECIDES_TIES
bool met_tie;  // a vertex of this lane lies on a fourth plane
#endif

shared real4 plane_equation[SUBGROUP_PLANES * subgroups];  // n, h
shared real2 plane_size[SUBGROUP_PLANES * subgroups];      // norm, distance
shared int plane_id[SUBGROUP_PLANES * subgroups];          // sorted seed, or wall id

int id_of(uint plane) {
    return plane_id[SUBGROUP_PLANES * SUBGROUP + plane];
}

Plane plane_at(uint plane) {
    const uint at = SUBGROUP_PLANES * SUBGROUP + plane;
    const real4 e = plane_equation[at];
    const real2 size = plane_size[at];
    return Plane(e.x, e.y, e.z, e.w, size.x, size.y);
}

// One lane calls it.
void set_plane(uint plane, Plane p, int id) {
    const uint at = SUBGROUP_PLANES * SUBGROUP + plane;
    plane_equation[at] = real4(p.x, p.y, p.z, p.h);
    plane_size[at] = real2(p.norm, p.distance);
    plane_id[at] = id;
}

// Planes to test, one a lane, in the words of the sorted store of candidates.
#ifdef CLIP_FLOAT64
const uint words_of_real = 2u;
void put_test(uint i, real number) {
    const uvec2 words = unpackDouble2x32(number);
    STORE_WORD(2u * i) = words.x;
    STORE_WORD(2u * i + 1u) = words.y;
}
real get_test(uint i) {
    return packDouble2x32(uvec2(STORE_WORD(2u * i), STORE_WORD(2u * i + 1u)));
}
#else
const uint words_of_real = 1u;
void put_test(uint i, real number) {
    STORE_WORD(i) = floatBitsToUint(number);
}
real get_test(uint i) {
    return uintBitsToFloat(STORE_WORD(i));
}
#endif
const uint tests_at_once = uint(lanes) * words_of_real < 32u ? uint(lanes) : 32u / words_of_real;
#define TEST_ID(i) STORE_WORD(5u * tests_at_once * words_of_real + (i))

// Sets this lane's plane to test next, of a sorted seed or a wall id.
void prepare_test(Plane p, int id) {
    put_test(4u * lane, p.x);
    put_test(4u * lane + 1u, p.y);
    put_test(4u * lane + 2u, p.z);
    put_test(4u * lane + 3u, p.h);
    put_test(4u * tests_at_once + lane, p.norm);
    TEST_ID(lane) = uint(id);
}

void measure_radius() {
    float reach = float(vertex_norm[0] + vertex_error[0]);
    [[unroll]] for (int s = 1; s < slots; ++s) reach = max(reach, float(vertex_norm[s] + vertex_error[s]));
#ifdef CLIP_FLOAT64
    const real farthest = real(largest(reach)) * 1.000001LF;
#else
    const real farthest = largest(reach);
#endif
    security = security_radius_squared(farthest, real(0));
    if (weighted != 0u) radius_of_all = farthest * real(1.00001);
}

// Measures how far the vertex balls reach along the axes, down and up: upper bounds.
void measure_reach(out vec3 down, out vec3 up) {
    down = vec3(0.0);
    up = vec3(0.0);
    [[unroll]] for (int s = 0; s < slots; ++s) {
        extend_reach(vec3(vertex_x[s], vertex_y[s], vertex_z[s]), float(vertex_error[s]), down, up);
    }
    down = vec3(largest(down.x), largest(down.y), largest(down.z));
    up = vec3(largest(up.x), largest(up.y), largest(up.z));
}

void set_vertex(int s, Vertex vertex, uint planes) {
    vertex_x[s] = vertex.x;
    vertex_y[s] = vertex.y;
    vertex_z[s] = vertex.z;
    vertex_norm[s] = vertex.norm;
    vertex_error[s] = vertex.error;
    vertex_planes[s] = planes;
}

// Makes the box: planes 0 .. 5 are the walls xmin, xmax, ymin, ymax, zmin, zmax.
void start_cell() {
    if (lane < 6u) {
        const uint axis = lane / 2u;
        const real side = (lane & 1u) != 0u ? real(1) : real(-1);
        const real wall = start_wall(lane);
        set_plane(lane, Plane(axis == 0u ? side : real(0), axis == 1u ? side : real(0), axis == 2u ? side : real(0), wall,
                              real(1), wall), -1 - int(lane));
    }
    prepare_bounds();
    free_planes = all_planes & ~0x3fu;
#ifdef DECIDES_TIES
    met_tie = false;
#endif
    [[unroll]] for (int s = 0; s < slots; ++s) {
        vertex_x[s] = vertex_y[s] = vertex_z[s] = vertex_norm[s] = vertex_error[s] = real(0);
        vertex_planes[s] = 0u;
    }
    share();
    if (lane < 8u) {
        const uint x = lane & 1u, y = 2u + ((lane >> 1) & 1u), z = 4u + (lane >> 2);
        const Plane a = plane_at(x), b = plane_at(y), c = plane_at(z);
        const real length = sqrt(fma(a.h, a.h, fma(b.h, b.h, c.h * c.h)));
        // The determinant is the product of the three signs.
        const bool odd = (bitCount(lane) & 1) != 0;
        const uint positive = pack_planes(x, y, z), negative = pack_planes(y, x, z);
        set_vertex(0, Vertex(a.x * a.h, b.y * b.h, c.z * c.h, length,
                             vertex_error_bound(real(1), a.distance + b.distance + c.distance, length)),
                   odd ? positive : negative);
    }
    if (alike(!is_positive_below(real(1), max_condition))) status = STATUS_NEEDS_EXACT;
    measure_radius();
}

#ifdef DECIDES_TIES
// Decides on vertices of this lane that the filter did not decide. Returns false when it cannot. Of equal seeds the
// first has the cell; where some may not be marked, the CPU must find it.
bool decide_exactly(uint undecided, int id) {
    bool decided = undecided == 0u || state.suspects == 0u;
    [[dont_unroll]] for (; undecided != 0u; undecided &= undecided - 1u) {
        uint planes = 0u;
        [[unroll]] for (int s = 0; s < slots; ++s)
            if (findLSB(undecided) == s) planes = vertex_planes[s];
        const int side = exact_side(id_of(plane_of(planes, 0)), id_of(plane_of(planes, 1)), id_of(plane_of(planes, 2)), id);
        decided = decided && side != side_unknown;
        if (side == 0) met_tie = true;
        [[unroll]] for (int s = 0; s < slots; ++s)
            if (findLSB(undecided) == s) killed[s] = killed[s] || side == 1;
    }
    return decided;
}
#endif

// The distance of the plane is not set.
Plane plane_to_test(uint i) {
    return Plane(get_test(4u * i), get_test(4u * i + 1u), get_test(4u * i + 2u), get_test(4u * i + 3u),
                 get_test(4u * tests_at_once + i), real(0));
}

// Returns whether a plane may cut a vertex off.
bool reaches(Plane p) {
    real farthest = fma(p.norm, vertex_error[0], side_of(p, vertex_x[0], vertex_y[0], vertex_z[0]));
    [[unroll]] for (int s = 1; s < slots; ++s)
        farthest = max(farthest, fma(p.norm, vertex_error[s], side_of(p, vertex_x[s], vertex_y[s], vertex_z[s])));
    return any_lane(!(farthest < -side_bound(p, real(0))));
}

// Marks the vertices outside of a plane. Returns false when that is uncertain, which sets the status, or when there is
// nothing to cut. A plane that reaches a vertex and has none on it nearly always cuts.
bool mark_killed(Plane p, int id) {
    bool any_killed = false, any_undecided = false;
    uint undecided = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const real side = side_of(p, vertex_x[s], vertex_y[s], vertex_z[s]), bound = side_bound(p, vertex_error[s]);
        // Without weights a free slot lies inside.
        const bool counts = weighted == 0u || vertex_planes[s] != 0u, beyond = side > bound, unsure = !(abs(side) > bound);
        killed[s] = counts && beyond;
        any_killed = any_killed || killed[s];
        any_undecided = any_undecided || (counts && unsure);
#ifdef DECIDES_TIES
        undecided |= uint(counts && unsure) << s;
#endif
    }
    bool decided = !any_lane(any_undecided);
#ifdef DECIDES_TIES
    if (!decided) {
        decided = !any_lane(!decide_exactly(undecided, id));
        [[unroll]] for (int s = 0; s < slots; ++s) any_killed = any_killed || killed[s];
    }
    status = decided ? STATUS_CERTIFIED : STATUS_NEEDS_EXACT;
    return decided && any_lane(any_killed);
#else
    status = decided ? STATUS_CERTIFIED : STATUS_NEEDS_EXACT;
    return weighted != 0u ? decided && any_lane(any_killed) : decided;
#endif
}

uint count_vertices() {
    uint mine = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s) mine += uint(vertex_planes[s] != 0u);
    return sum(mine);
}

uint planes_in_use() {
    uint mine = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s)
        if (vertex_planes[s] != 0u)
            for (int k = 0; k < 3; ++k) mine |= 1u << plane_of(vertex_planes[s], k);
    return all_bits(mine);
}

// Writes the planes of all vertices to VERTEX_LIST. Returns the number of vertices.
uint list_vertices() {
    share();
    uint listed = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const bool is_alive = vertex_planes[s] != 0u;
        uint count;
        const uint at = listed + rank_among(is_alive, count);
        if (is_alive) VERTEX_LIST(at) = vertex_planes[s];
        listed += count;
    }
    share();
    return listed;
}

// Removes the killed vertices and writes their planes to KILLED, filled up to a multiple of four with vertices on no
// plane. Returns a quarter of the length of that list.
uint remove_killed() {
    uint length = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s)
        if (s == 0 || any_lane(killed[s])) {  // rare except in the first slot
            uint more;
            const uint at = length + rank_among(killed[s], more);
            length += more;
            if (killed[s]) KILLED(at) = vertex_planes[s];
            const real kept = killed[s] ? real(0) : real(1);
            vertex_x[s] *= kept;
            vertex_y[s] *= kept;
            vertex_z[s] *= kept;
            vertex_norm[s] *= kept;
            vertex_planes[s] = killed[s] ? 0u : vertex_planes[s];
        }
    const uint fours = (length + 3u) / 4u;
    if (length + lane < 4u * fours) KILLED(length + lane) = 0xffffffu;
    share();
    return fours;
}

// Removes the killed vertices and writes the edges of the horizon to HORIZON. Returns their number. Edge (a, b) of a
// killed vertex is on the horizon if and only if no killed vertex has (b, a). The horizon is a ring, so each plane has at
// most one edge of it.
uint find_horizon() {
    const uint fours = remove_killed();
    uint next[planes_of_lane], previous[planes_of_lane];  // planes b of edges (a, b) and (b, a) of killed vertices
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) next[i] = previous[i] = 0u;
    for (uint first = 0u; first < fours; ++first)
        [[unroll]] for (uint k = 0u; k < 4u; ++k) {
            const uint planes = KILLED(4u * first + k);
            const uint a = plane_of(planes, 0), b = plane_of(planes, 1), c = plane_of(planes, 2);
            const uint a_bit = 1u << (a & 31u), b_bit = 1u << (b & 31u), c_bit = 1u << (c & 31u);
            [[unroll]] for (int i = 0; i < planes_of_lane; ++i) {
                const uint mine = uint(i * lanes) + lane;
                const bool is_a = mine == a, is_b = mine == b, is_c = mine == c;
                next[i] |= (is_a ? b_bit : 0u) | (is_b ? c_bit : 0u) | (is_c ? a_bit : 0u);
                previous[i] |= (is_a ? c_bit : 0u) | (is_b ? a_bit : 0u) | (is_c ? b_bit : 0u);
            }
        }
    uint count = 0u;
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) {
        const uint successor = next[i] & ~previous[i];
        uint more;
        const uint rank = rank_among(successor != 0u, more);
        if (successor != 0u) HORIZON(count + rank) = (uint(i * lanes) + lane) | (uint(findMSB(successor)) << 8);
        count += more;
    }
    share();
    return count;
}

// Makes vertices of a plane with edges of the horizon, from `made` on, in the free slots s. The i-th free slot takes the
// i-th edge; its own lane makes the vertex.
void make_vertices(int s, Plane p, uint third, uint horizon_count, inout uint made, inout bool certain) {
    const bool is_free = vertex_planes[s] == 0u;
    uint count;
    const uint edge = made + rank_among(is_free, count);
    if (is_free && edge < horizon_count) {
        const uint planes = HORIZON(edge);
        Vertex vertex;
        certain = find_vertex(plane_at(plane_of(planes, 0)), plane_at(plane_of(planes, 1)), p, vertex) && certain;
        set_vertex(s, vertex, planes | third);
    }
    made += count;
}

// Replaces the killed vertices by the vertices of the new plane with the horizon.
void cut(Plane p, int id) {
    if (weighted != 0u) {
        bool any_left = false;
        [[unroll]] for (int s = 0; s < slots; ++s) any_left = any_left || (vertex_planes[s] != 0u && !killed[s]);
        if (!any_lane(any_left)) {  // the cell is empty, if the seed is unique
            status = alike(state.suspects == 0u) ? STATUS_EMPTY : STATUS_NEEDS_EXACT;
            return;
        }
    }
    const uint horizon_count = find_horizon();
    if (free_planes == 0u) {
        free_planes = all_planes & ~planes_in_use();
        if (free_planes == 0u) {
            status = STATUS_PLANE_OVERFLOW;
            return;
        }
    }
    const uint plane = uint(findLSB(free_planes));
    free_planes &= free_planes - 1u;
    const uint third = plane << 16;
    p.distance = distance_of(p.h, p.norm);
    // The lane of the plane's number writes it: addresses by lane cost less.
    if (lane == plane % uint(lanes)) set_plane(lanes >= SUBGROUP_PLANES ? lane : plane, p, id);

    uint made = 0u;
    bool certain = true;
    make_vertices(0, p, third, horizon_count, made, certain);
    if (made < horizon_count)  // rare
        [[unroll]] for (int s = 1; s < slots; ++s) make_vertices(s, p, third, horizon_count, made, certain);
    status = made < horizon_count ? STATUS_VERTEX_OVERFLOW
                                  : (any_lane(!certain) ? STATUS_NEEDS_EXACT : STATUS_CERTIFIED);
    measure_radius();
}

// Clips by the tested plane i, which reaches the cell.
void clip_by(Plane p, uint i) {
    const int id = int(TEST_ID(i));
    if (mark_killed(p, id)) cut(p, id);
}

#endif

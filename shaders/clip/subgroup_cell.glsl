// One Voronoi cell, made by a subgroup. Each lane holds some of the vertices; the planes are in shared memory.
// A cut lists the killed vertices. Each lane takes a plane, and finds its neighbors on the horizon, the ring of edges
// around the killed vertices, from those of them that lie on the plane.
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
const int planes_of_lane = (int(max_planes) + lanes - 1) / lanes;

real vertex_x[slots], vertex_y[slots], vertex_z[slots];
real vertex_error[slots];
uint vertex_planes[slots];     // 0 where there is no vertex
bool killed[slots];
PlaneSet free_planes;          // planes not in use
real security;                 // squared radius; in a power diagram a key
real radius_of_all;            // in a power diagram, a bound of the distance of all vertices
#ifdef DECIDES_TIES
bool met_tie;  // a vertex of this lane lies on a fourth plane
#endif

shared int plane_id[max_planes * subgroups];  // sorted seed, or wall id

int id_of(uint plane) {
    return plane_id[max_planes * SUBGROUP + plane];
}

// Numbers in shared memory, counted from the first word.
#ifdef CLIP_FLOAT64
void put_real(uint i, real number) {
    const uvec2 both = unpackDouble2x32(number);
    WORD(2u * i) = both.x;
    WORD(2u * i + 1u) = both.y;
}
real get_real(uint i) {
    return packDouble2x32(uvec2(WORD(2u * i), WORD(2u * i + 1u)));
}
#else
void put_real(uint i, real number) {
    WORD((i)) = floatBitsToUint(number);
}
real get_real(uint i) {
    return uintBitsToFloat(WORD((i)));
}
#endif

// n and h of planes to test are at the beginning of the store. Those of the cell's planes have words of their own.
const uint first_plane_number = first_plane_word / words_of_real;
void put_plane(uint at, Plane p) {
    put_real(at, p.x);
    put_real(at + 1u, p.y);
    put_real(at + 2u, p.z);
    put_real(at + 3u, p.h);
}

Plane plane_at(uint plane) {
    const uint at = first_plane_number + 4u * plane;
    const real x = get_real(at), y = get_real(at + 1u), z = get_real(at + 2u), h = get_real(at + 3u);
    const real norm = sqrt(fma(x, x, fma(y, y, z * z)));
    return Plane(x, y, z, h, norm, distance_of(h, norm));
}

// One lane calls it.
void set_plane(uint plane, Plane p, int id) {
    put_plane(first_plane_number + 4u * plane, p);
    plane_id[max_planes * SUBGROUP + plane] = id;
}

// Planes to test, one a lane.
const uint tests_at_once = uint(lanes) * words_of_real < 32u ? uint(lanes) : 32u / words_of_real;
real test_norm;  // of this lane's plane
int test_id;     // sorted seed, or wall id

void prepare_test(Plane p, int id) {
    put_plane(4u * lane, p);
    test_norm = p.norm;
    test_id = id;
}

void measure_radius() {
    float reach = 0.0;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const real x = vertex_x[s], y = vertex_y[s], z = vertex_z[s];
        reach = max(reach, float(sqrt(fma(x, x, fma(y, y, z * z))) + vertex_error[s]));
    }
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
    free_planes = all_planes;
    for (int wall = 0; wall < 6; ++wall) free_planes = without_lowest(free_planes);
#ifdef DECIDES_TIES
    met_tie = false;
#endif
    [[unroll]] for (int s = 0; s < slots; ++s) {
        vertex_x[s] = vertex_y[s] = vertex_z[s] = vertex_error[s] = real(0);
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
    if (alike(!(max_condition > real(1)))) status = STATUS_NEEDS_EXACT;
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
    return Plane(get_real(4u * i), get_real(4u * i + 1u), get_real(4u * i + 2u), get_real(4u * i + 3u),
                 from_lane(test_norm, i), real(0));
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

PlaneSet set_of_vertex(uint planes) {
    return set_of(plane_of(planes, 0)) | set_of(plane_of(planes, 1)) | set_of(plane_of(planes, 2));
}

// The list has at most one set a lane.
const bool killed_overlap_horizon = uint(lanes) > SUBGROUP_PLANES;
#ifdef TWO_WORDS_OF_PLANES
void put_killed(uint i, PlaneSet planes) {
    KILLED(2u * i) = planes.x;
    KILLED(2u * i + 1u) = planes.y;
}
PlaneSet get_killed(uint i) {
    return PlaneSet(KILLED(2u * i), KILLED(2u * i + 1u));
}
#else
void put_killed(uint i, PlaneSet planes) {
    KILLED((i)) = planes;
}
PlaneSet get_killed(uint i) {
    return KILLED((i));
}
#endif

PlaneSet planes_in_use() {
    PlaneSet mine = no_planes;
    [[unroll]] for (int s = 0; s < slots; ++s)
        if (vertex_planes[s] != 0u) mine |= set_of_vertex(vertex_planes[s]);
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

// Gives each lane its planes, each a set of its own.
void take_planes(out PlaneSet own[planes_of_lane], out PlaneSet ends[planes_of_lane]) {
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) {
        const uint mine = uint(i * lanes) + lane;
        own[i] = mine < max_planes ? set_of(mine) : no_planes;
        ends[i] = no_planes;
    }
}

// Adds four sets of KILLED to the symmetric differences of the planes that are in them.
void add_killed(uint first, PlaneSet own[planes_of_lane], inout PlaneSet ends[planes_of_lane]) {
    [[unroll]] for (uint k = 0u; k < 4u; ++k) {
        const PlaneSet planes = get_killed(first + k);
        [[unroll]] for (int i = 0; i < planes_of_lane; ++i)
            ends[i] ^= is_empty(planes & own[i]) ? no_planes : planes;
    }
}

// Lists the sets of planes of killed vertices, at most one a lane, and adds them.
void add_killed_of(bool is_killed, uint planes, PlaneSet own[planes_of_lane], inout PlaneSet ends[planes_of_lane]) {
    uint length;
    const uint at = rank_among(is_killed, length), end = max((length + 3u) & ~3u, 4u);
    if (is_killed) put_killed(at, set_of_vertex(planes));
    if (length + lane < end) put_killed(length + lane, no_planes);
    share();
    add_killed(0u, own, ends);
    if (end > 4u)  // rare
        for (uint first = 4u; alike(first < end); first += 4u) add_killed(first, own, ends);
}

// Removes the killed vertices and writes the edges of the horizon to HORIZON: two planes each, 16 bits apart. Returns
// their number. The killed vertices on a plane are a chain along its face, and each edge within the chain joins two of
// them. So in the symmetric difference of their sets the plane's two neighbors on the horizon remain. The lower plane
// of an edge writes it.
uint find_horizon() {
    PlaneSet own[planes_of_lane], ends[planes_of_lane];
    take_planes(own, ends);
    if (killed_overlap_horizon) share();  // the sets replace edges
    add_killed_of(killed[0], vertex_planes[0], own, ends);
    [[unroll]] for (int s = 1; s < slots; ++s)
        if (any_lane(killed[s])) {  // rare
            share();                // the sets replace others
            add_killed_of(killed[s], vertex_planes[s], own, ends);
        }
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const real kept = killed[s] ? real(0) : real(1);
        vertex_x[s] *= kept;
        vertex_y[s] *= kept;
        vertex_z[s] *= kept;
        vertex_error[s] *= kept;
        vertex_planes[s] = killed[s] ? 0u : vertex_planes[s];
    }
    if (killed_overlap_horizon) share();
    uint count = 0u;
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) {
        const uint mine = uint(i * lanes) + lane;
        const PlaneSet higher = ends[i] & planes_behind(own[i]);
        const bool one = !is_empty(higher), two = !is_empty(without_lowest(higher));
        uint ones, twos;
        const uint rank_of_one = rank_among(one, ones), rank_of_two = rank_among(two, twos);
        if (one) HORIZON(count + rank_of_one) = mine | (lowest_of(higher) << 16);
        if (two) HORIZON(count + ones + rank_of_two) = mine | (highest_of(higher) << 16);
        count += ones + twos;
    }
    share();
    return count;
}

// Makes vertices of a plane with edges of the horizon, from `made` on, in the free slots s. The i-th free slot takes the
// i-th edge; its own lane makes the vertex.
void make_vertices(int s, Plane p, uint plane, uint horizon_count, inout uint made, inout bool certain) {
    const bool is_free = vertex_planes[s] == 0u;
    uint count;
    const uint edge = made + rank_among(is_free, count);
    if (is_free && edge < horizon_count) {
        const uint ends = HORIZON(edge);
        Vertex vertex;
        bool is_certain;
        const real det = find_vertex(plane_at(ends & 0xffffu), plane_at(ends >> 16), p, vertex, is_certain);
        certain = is_certain && certain;
        // The positive order has the new plane in the middle, behind the second end or the first.
        set_vertex(s, vertex, (det < real(0) ? ends : (ends >> 16) | (ends << 16)) | (plane << 8));
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
    if (is_empty(free_planes)) {
        free_planes = all_planes & ~planes_in_use();
        if (is_empty(free_planes)) {
            status = STATUS_PLANE_OVERFLOW;
            return;
        }
    }
    const uint plane = lowest_of(free_planes);
    free_planes = without_lowest(free_planes);
    p.distance = distance_of(p.h, p.norm);
    // The lane of the plane's number writes it: addresses by lane cost less.
    if (lane == plane % uint(lanes)) set_plane(uint(lanes) >= max_planes ? lane : plane, p, id);

    uint made = 0u;
    bool certain = true;
    make_vertices(0, p, plane, horizon_count, made, certain);
    if (made < horizon_count)  // rare
        [[unroll]] for (int s = 1; s < slots; ++s) make_vertices(s, p, plane, horizon_count, made, certain);
    status = made < horizon_count ? STATUS_VERTEX_OVERFLOW
                                  : (any_lane(!certain) ? STATUS_NEEDS_EXACT : STATUS_CERTIFIED);
    measure_radius();
}

// Clips by the tested plane i, which reaches the cell.
void clip_by(Plane p, uint i) {
    const int id = int(from_lane(uint(test_id), i));
    if (mark_killed(p, id)) cut(p, id);
}

#endif

// One Voronoi cell of a subgroup, as in clip/invocation_cell.glsl; but every lane holds a few of the vertices, and the
// planes are in shared memory. A free vertex lies in the seed itself, which no plane cuts off but in a power diagram. The
// .comp declares `push`, with extent and bounded, before.
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

layout(constant_id = CONSTANT_MOST_VERTICES) const int most_vertices = 64;

const int slots = (most_vertices + lanes - 1) / lanes;  // vertices of a lane
const uint all_planes = 0xffffffffu >> (32 - SUBGROUP_PLANES);

real vertex_x[slots], vertex_y[slots], vertex_z[slots];
real vertex_error[slots];
uint vertex_planes[slots];
uint alive, killed;         // a bit for each slot
uint planes_used;           // all that are in use, and maybe more
real largest_error, security;  // over all vertices; security: squared radius, or in a power diagram rank
real radius_of_all;            // in a power diagram, at least the distance of any vertex
#ifdef DECIDES_TIES
bool met_tie;  // a vertex of this lane lies on a plane that it is not of
#endif

shared real4 plane_equation[SUBGROUP_PLANES * subgroups];  // n, h
shared real plane_norm[SUBGROUP_PLANES * subgroups], plane_distance[SUBGROUP_PLANES * subgroups];
shared int plane_id[SUBGROUP_PLANES * subgroups];  // sorted seed, or wall id
shared real4 test_equation[lanes * subgroups];
shared real test_norm[lanes * subgroups];

int id_of(uint plane) {
    return plane_id[SUBGROUP_PLANES * SUBGROUP + plane];
}

Plane plane_at(uint plane) {
    const uint at = SUBGROUP_PLANES * SUBGROUP + plane;
    const real4 e = plane_equation[at];
    return Plane(e.x, e.y, e.z, e.w, plane_norm[at], plane_distance[at]);
}

// One lane calls it.
void set_plane(uint plane, Plane p, int id) {
    const uint at = SUBGROUP_PLANES * SUBGROUP + plane;
    plane_equation[at] = real4(p.x, p.y, p.z, p.h);
    plane_norm[at] = p.norm;
    plane_distance[at] = p.distance;
    plane_id[at] = id;
}

// Sets this lane's plane of those to test next.
void prepare_test(Plane p) {
    const uint at = uint(lanes) * SUBGROUP + lane;
    test_equation[at] = real4(p.x, p.y, p.z, p.h);
    test_norm[at] = p.norm;
}

Plane plane_to_test(uint i) {
    const uint at = uint(lanes) * SUBGROUP + i;
    const real4 e = test_equation[at];
    return Plane(e.x, e.y, e.z, e.w, test_norm[at],
                 weighted != 0u ? distance_of(e.w, test_norm[at]) : real(0.5) * test_norm[at]);
}

void measure_radius_and_error() {
    float farthest = 0.0, error = 0.0;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const real x = vertex_x[s], y = vertex_y[s], z = vertex_z[s];
        farthest = max(farthest, float(fma(x, x, fma(y, y, z * z))));
        error = max(error, float(vertex_error[s]));
    }
#ifdef CLIP_FLOAT64
    const real radius_squared = real(largest(farthest)) * 1.000001LF;
    largest_error = real(largest(error)) * 1.000001LF + 1.0e-37LF;
#else
    const real radius_squared = largest(farthest);
    largest_error = largest(error);
#endif
    security = security_radius_squared(radius_squared, largest_error);
    if (weighted != 0u) radius_of_all = (sqrt(radius_squared) + largest_error) * real(1.00001);
}

// How far the balls around vertices that go through the seed reach along the axes, at least: down and up.
void measure_reach(out vec3 down, out vec3 up) {
    down = vec3(0.0);
    up = vec3(0.0);
    [[unroll]] for (int s = 0; s < slots; ++s) {
        extend_reach(vec3(vertex_x[s], vertex_y[s], vertex_z[s]), float(vertex_error[s]), down, up);
    }
    down = vec3(largest(down.x), largest(down.y), largest(down.z));
    up = vec3(largest(up.x), largest(up.y), largest(up.z));
}

// Puts the vertex of planes a, b, c into a slot of this lane; false when it is uncertain.
bool set_vertex(int s, uint a, uint b, uint c, Plane last) {
    Vertex vertex;
    const bool certain = find_vertex(plane_at(a), plane_at(b), last, vertex);
    vertex_x[s] = vertex.x;
    vertex_y[s] = vertex.y;
    vertex_z[s] = vertex.z;
    vertex_error[s] = vertex.error;
    vertex_planes[s] = pack_planes(a, b, c);
    alive |= 1u << s;
    return certain;
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
    planes_used = 0x3fu;
    alive = 0u;
#ifdef DECIDES_TIES
    met_tie = false;
#endif
    [[unroll]] for (int s = 0; s < slots; ++s) {
        vertex_x[s] = vertex_y[s] = vertex_z[s] = vertex_error[s] = real(0);
        vertex_planes[s] = 0u;
    }
    share();
    bool certain = true;
    if (lane < 8u) {
        const uint x = lane & 1u, y = 2u + ((lane >> 1) & 1u), z = 4u + (lane >> 2);
        // det is the product of the three signs.
        const bool odd = (bitCount(lane) & 1) != 0;
        certain = set_vertex(0, odd ? x : y, odd ? y : x, z, plane_at(z));
    }
    if (any_lane(!certain)) status = STATUS_NEEDS_EXACT;
    measure_radius_and_error();
}

#ifdef DECIDES_TIES
// Decides on vertices of this lane that the filter is not sure of; false when that is not possible. Of equal seeds the
// first has the cell: where some may not be marked the CPU has to find it.
bool decide_exactly(uint undecided, int id) {
    bool decided = undecided == 0u || state.suspects == 0u;
    [[dont_unroll]] for (; undecided != 0u; undecided &= undecided - 1u) {
        uint planes = 0u;
        [[unroll]] for (int s = 0; s < slots; ++s)
            if (findLSB(undecided) == s) planes = vertex_planes[s];
        const int side = exact_side(id_of(plane_of(planes, 0)), id_of(plane_of(planes, 1)), id_of(plane_of(planes, 2)), id);
        decided = decided && side != side_unknown;
        if (side == 0) met_tie = true;
        if (side == 1) killed |= undecided & (0u - undecided);
    }
    return decided;
}
#endif

// Marks the vertices outside a plane; true when there are any. The status changes when that is uncertain.
bool test_plane(Plane p, int id) {
    const real most = side_bound(p, largest_error);
    real sides[slots];
    bool near = false;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        sides[s] = side_of(p, vertex_x[s], vertex_y[s], vertex_z[s]);
        const bool reached = !(sides[s] < -most);
        near = near || reached;
    }
    if (!any_lane(near)) return false;
    uint outside = 0u, inside = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const real bound = side_bound(p, vertex_error[s]);
        outside |= uint(sides[s] > bound) << s;
        inside |= uint(sides[s] < -bound) << s;
    }
    killed = alive & outside;
    const uint undecided = alive & ~(outside | inside);
    bool decided = !any_lane(undecided != 0u);
#ifdef DECIDES_TIES
    if (!decided) decided = !any_lane(!decide_exactly(undecided, id));
#endif
    if (!decided) {
        status = STATUS_NEEDS_EXACT;
        return false;
    }
    return any_lane(killed != 0u);
}

uint planes_in_use() {
    uint mine = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s)
        if ((alive & (1u << s)) != 0u)
            for (int k = 0; k < 3; ++k) mine |= 1u << plane_of(vertex_planes[s], k);
    return all_bits(mine);
}

// Writes the planes of all vertices down and returns how many they are.
uint list_vertices() {
    share();
    uint listed = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const bool is_alive = (alive & (1u << s)) != 0u;
        uint count;
        const uint at = listed + rank_among(is_alive, count);
        if (is_alive) VERTEX_LIST(at) = vertex_planes[s];
        listed += count;
    }
    share();
    return listed;
}

// find_horizon() leaves it so; searches use the same memory.
void forget_edges(uint a) {
    EDGES_FROM(a) = 0u;
    EDGES_TO(a) = 0u;
}

void prepare_cuts() {
    for (uint a = lane; a < SUBGROUP_PLANES; a += uint(lanes)) forget_edges(a);
}

// Edge (a, b) of a killed vertex is on the horizon iff no killed vertex has (b, a). Writes down those and returns how
// many; 0 when they are no ring.
uint find_horizon() {
    [[unroll]] for (int s = 0; s < slots; ++s)
        if ((killed & (1u << s)) != 0u) {
            const uint a = plane_of(vertex_planes[s], 0), b = plane_of(vertex_planes[s], 1),
                       c = plane_of(vertex_planes[s], 2);
            const uint a_bit = 1u << a, b_bit = 1u << b, c_bit = 1u << c;
            atomicOr(EDGES_FROM(a), b_bit);
            atomicOr(EDGES_TO(a), c_bit);
            atomicOr(EDGES_FROM(b), c_bit);
            atomicOr(EDGES_TO(b), a_bit);
            atomicOr(EDGES_FROM(c), a_bit);
            atomicOr(EDGES_TO(c), b_bit);
        }
    share();
    // The horizon is a ring: no two killed vertices have the same edge, so that all of them are counted here, and no plane has two
    // edges of the horizon from it. Then none has two to it, as every vertex adds one of both.
    uint count = 0u, faults = 0u - 3u * uint(bitCount(killed));
    for (uint first = 0u; first < SUBGROUP_PLANES; first += uint(lanes)) {
        const uint a = first + lane;
        uint successor = 0u;
        if (lanes <= SUBGROUP_PLANES || a < SUBGROUP_PLANES) {
            const uint from = EDGES_FROM(a), to = EDGES_TO(a);
            successor = from & ~to;
            faults += uint(bitCount(from));
            faults += (successor & (successor - 1u)) != 0u ? 1000u : 0u;
            forget_edges(a);
        }
        uint more;
        const uint rank = rank_among(successor != 0u, more);
        if (successor != 0u) HORIZON(count + rank) = a | (uint(findLSB(successor)) << 8);
        count += more;
    }
    share();
    return sum(faults) == 0u ? count : 0u;
}

// Replaces the killed vertices by those of the new plane with the horizon.
void cut(Plane p, int id) {
    if (weighted != 0u && !any_lane((alive & ~killed) != 0u)) {  // no interior; perhaps it has none of its own
        status = state.suspects == 0u ? STATUS_EMPTY : STATUS_NEEDS_EXACT;
        return;
    }
    const uint horizon_count = find_horizon();
    if (horizon_count == 0u) {
        status = STATUS_NEEDS_EXACT;
        return;
    }
    alive &= ~killed;
    if (planes_used == all_planes) planes_used = planes_in_use();
    if (planes_used == all_planes) {
        status = STATUS_PLANE_OVERFLOW;
        return;
    }
    const uint plane = uint(findLSB(~planes_used));
    planes_used |= 1u << plane;
    if (lane == 0u) set_plane(plane, p, id);

    // The i-th free slot takes the i-th edge; its own lane makes the vertex.
    uint made = 0u;
    bool certain = true;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const bool is_free = (alive & (1u << s)) == 0u;
        if (is_free) vertex_x[s] = vertex_y[s] = vertex_z[s] = vertex_error[s] = real(0);
        if (made < horizon_count) {
            uint count;
            const uint edge = made + rank_among(is_free, count);
            if (is_free && edge < horizon_count)
                certain = set_vertex(s, HORIZON(edge) & 0xffu, HORIZON(edge) >> 8, plane, p) && certain;
            made += count;
        }
    }
    if (made < horizon_count)
        status = STATUS_VERTEX_OVERFLOW;
    else if (any_lane(!certain))
        status = STATUS_NEEDS_EXACT;
    measure_radius_and_error();
}

#endif

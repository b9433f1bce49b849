// One Voronoi cell in the private memory of an invocation: a simple polytope, whose vertices lie on exactly three
// planes each. It is relative to its seed, in units of about the distance to its nearest neighbor. The .comp declares
// `push`, with extent, before.
#ifndef VOTESS_CLIP_INVOCATION_CELL_GLSL
#define VOTESS_CLIP_INVOCATION_CELL_GLSL

#ifdef DECIDES_TIES
#include "clip/exact_side.glsl"
#endif
#include "clip/filter.glsl"
#include "shared/interface.h"

layout(constant_id = CONSTANT_MAX_PLANES) const int max_planes = 32;
layout(constant_id = CONSTANT_MAX_VERTICES) const int max_vertices = 64;

// Vertices of a step of a loop: their loads overlap. The arrays have room to read beyond the last vertex.
const int side_by_side = 4;
const int plane_words = max_planes / 32;
const int vertex_words = max_vertices / 32;

real plane_x[max_planes], plane_y[max_planes], plane_z[max_planes], plane_h[max_planes];
real plane_norm[max_planes];
int plane_id[max_planes];  // sorted seed, or wall id
uint planes_used[plane_words];

real vertex_x[max_vertices], vertex_y[max_vertices], vertex_z[max_vertices];
real vertex_error[max_vertices];    // |x - X| + 6u |x|
uint vertex_planes[max_vertices];
int vertex_count;

uint killed[vertex_words];                    // vertices outside the last tested plane
uint edges_killed[max_planes * plane_words];  // bit b of row a: edge (a, b) of a killed vertex
uint horizon[max_planes];                     // edges (a, b) with one vertex killed: a | b << 8
uint status;
real radius_squared;  // over all vertices, at the last test
real largest_error;   // at least that of any vertex

#ifdef DECIDES_TIES
uint undecided[vertex_words];  // vertices that the filter did not decide
bool met_tie;                  // a vertex lies on a fourth plane
#endif

Plane tested;   // the last one
int tested_id;  // its id

void set_plane(uint slot, Plane p, int id) {
    plane_x[slot] = p.x;
    plane_y[slot] = p.y;
    plane_z[slot] = p.z;
    plane_h[slot] = p.h;
    plane_norm[slot] = p.norm;
    plane_id[slot] = id;
    planes_used[slot >> 5] |= 1u << (slot & 31u);
}

Plane plane_at(uint slot) {
    const real h = plane_h[slot], norm = plane_norm[slot];
    return Plane(plane_x[slot], plane_y[slot], plane_z[slot], h, norm, distance_of(h, norm));
}

// Appends the vertex of planes a, b, c.
void add_vertex(uint a, uint b, uint c) {
    if (vertex_count == max_vertices) {
        status = STATUS_VERTEX_OVERFLOW;
        return;
    }
    Vertex vertex;
    bool certain;
    const real det = find_vertex(plane_at(a), plane_at(b), plane_at(c), vertex, certain);
    if (!(certain && det > real(0))) {
        status = STATUS_NEEDS_EXACT;
        return;
    }
    vertex_x[vertex_count] = vertex.x;
    vertex_y[vertex_count] = vertex.y;
    vertex_z[vertex_count] = vertex.z;
    vertex_error[vertex_count] = vertex.error;
    largest_error = max(largest_error, vertex.error);
    vertex_planes[vertex_count] = pack_planes(a, b, c);
    ++vertex_count;
}

// Makes the box: planes 0 .. 5 are the walls xmin, xmax, ymin, ymax, zmin, zmax at distances `wall`.
void start_cell(real wall[6]) {
    status = STATUS_CERTIFIED;
    for (int w = 0; w < plane_words; ++w) planes_used[w] = 0u;
    for (uint i = 0u; i < 6u; ++i) {
        const real side = (i & 1u) != 0u ? real(1) : real(-1);
        set_plane(i, Plane(i / 2u == 0u ? side : real(0), i / 2u == 1u ? side : real(0), i / 2u == 2u ? side : real(0),
                           wall[i], real(1), wall[i]), -1 - int(i));
    }
    vertex_count = 0;
    largest_error = real(0);
#ifdef DECIDES_TIES
    met_tie = false;
#endif
    for (uint corner = 0u; corner < 8u; ++corner) {
        const uint x = corner & 1u, y = 2u + ((corner >> 1) & 1u), z = 4u + (corner >> 2);
        // det is the product of the three signs.
        if ((bitCount(corner) & 1) != 0)
            add_vertex(x, y, z);
        else
            add_vertex(y, x, z);
    }
}

#ifdef DECIDES_TIES
// Decides on the vertices that the filter did not decide. Returns whether any is outside. Of equal seeds the first has
// the cell; where some may not be marked, the CPU must find it.
bool decide_exactly() {
    bool cuts = false;
    for (int w = 0; w < vertex_words; ++w)
        for (uint rest = undecided[w]; rest != 0u; rest &= rest - 1u) {
            const uint planes = vertex_planes[32 * w + findLSB(rest)];
            const int side = exact_side(plane_id[plane_of(planes, 0)], plane_id[plane_of(planes, 1)],
                                        plane_id[plane_of(planes, 2)], tested_id);
            if (side == side_unknown || state.suspects != 0u) status = STATUS_NEEDS_EXACT;
            if (side == 0) met_tie = true;
            if (side != 1) continue;
            killed[w] |= rest & (0u - rest);
            cuts = true;
        }
    return cuts;
}
#endif

// Marks the vertices outside the new plane. Returns whether there are any. Sets the status when one is uncertain.
bool test_plane() {
    for (int w = 0; w < vertex_words; ++w) killed[w] = 0u;
    bool cuts = false;
#ifdef DECIDES_TIES
    for (int w = 0; w < vertex_words; ++w) undecided[w] = 0u;
    bool uncertain = false;
#endif
    real farthest = real(0);
    const real most = side_bound(tested, largest_error);
    for (int first = 0; first < vertex_count; first += side_by_side) {
        real sides[side_by_side];
        bool near = false;
        for (int i = 0; i < side_by_side; ++i) {
            const int v = first + i;
            const real x = vertex_x[v], y = vertex_y[v], z = vertex_z[v];
            const real side = side_of(tested, x, y, z);
            sides[i] = side;
            if (v < vertex_count) {
                farthest = max(farthest, fma(x, x, fma(y, y, z * z)));
                near = near || !(side < -most);
            }
        }
        if (!near) continue;
        for (int i = 0; i < side_by_side; ++i) {
            const int v = first + i;
            if (v >= vertex_count || sides[i] < -most) continue;
            const real bound = side_bound(tested, vertex_error[v]);
            if (sides[i] > bound) {
                killed[v >> 5] |= 1u << (v & 31);
                cuts = true;
            } else if (!(sides[i] < -bound)) {
#ifdef DECIDES_TIES
                undecided[v >> 5] |= 1u << (v & 31);
                uncertain = true;
#else
                status = STATUS_NEEDS_EXACT;
#endif
            }
        }
    }
    radius_squared = farthest;
#ifdef DECIDES_TIES
    if (uncertain && decide_exactly()) cuts = true;
#endif
    return cuts;
}

void measure_radius_and_error() {
    radius_squared = real(0);
    largest_error = real(0);
    for (int v = 0; v < vertex_count; ++v) {
        const real x = vertex_x[v], y = vertex_y[v], z = vertex_z[v];
        radius_squared = max(radius_squared, fma(x, x, fma(y, y, z * z)));
        largest_error = max(largest_error, vertex_error[v]);
    }
}

void note_planes_in_use() {
    for (int w = 0; w < plane_words; ++w) planes_used[w] = 0u;
    for (int v = 0; v < vertex_count; ++v)
        for (int k = 0; k < 3; ++k) {
            const uint p = plane_of(vertex_planes[v], k);
            planes_used[p >> 5] |= 1u << (p & 31u);
        }
}

// Returns a plane slot that is not in use, max_planes when there is none.
uint free_plane() {
    for (int w = 0; w < plane_words; ++w)
        if (planes_used[w] != 0xffffffffu) return uint(32 * w + findLSB(~planes_used[w]));
    return uint(max_planes);
}

bool all_are_killed() {
    int count = 0;
    for (int w = 0; w < vertex_words; ++w) count += bitCount(killed[w]);
    return count == vertex_count;
}

// Replaces the killed vertices by the vertices of the new plane with the horizon. Edge (a, b) of a killed vertex is on
// the horizon if and only if no killed vertex has (b, a).
void cut() {
    if (weighted != 0u && all_are_killed()) {  // the cell is empty, if the seed is unique
        status = state.suspects == 0u ? STATUS_EMPTY : STATUS_NEEDS_EXACT;
        return;
    }
    for (int w = 0; w < vertex_words; ++w)
        for (uint rest = killed[w]; rest != 0u; rest &= rest - 1u) {
            const uint planes = vertex_planes[32 * w + findLSB(rest)];
            for (int k = 0; k < 3; ++k)
                for (int i = 0; i < plane_words; ++i) edges_killed[int(plane_of(planes, k)) * plane_words + i] = 0u;
        }
    for (int w = 0; w < vertex_words; ++w)
        for (uint rest = killed[w]; rest != 0u; rest &= rest - 1u) {
            const uint planes = vertex_planes[32 * w + findLSB(rest)];
            for (int k = 0; k < 3; ++k) {
                const uint a = plane_of(planes, k), b = plane_of(planes, k == 2 ? 0 : k + 1);
                edges_killed[int(a) * plane_words + int(b >> 5)] |= 1u << (b & 31u);
            }
        }

    // The horizon is a ring: each plane is the first of one edge and the second of one.
    int horizon_count = 0;
    uint first_seen[plane_words], second_seen[plane_words];
    for (int w = 0; w < plane_words; ++w) first_seen[w] = second_seen[w] = 0u;
    for (int w = 0; w < vertex_words; ++w)
        for (uint rest = killed[w]; rest != 0u; rest &= rest - 1u) {
            const uint planes = vertex_planes[32 * w + findLSB(rest)];
            for (int k = 0; k < 3; ++k) {
                const uint a = plane_of(planes, k), b = plane_of(planes, k == 2 ? 0 : k + 1);
                if ((edges_killed[int(b) * plane_words + int(a >> 5)] & (1u << (a & 31u))) != 0u) continue;
                const uint a_bit = 1u << (a & 31u), b_bit = 1u << (b & 31u);
                if ((first_seen[a >> 5] & a_bit) != 0u || (second_seen[b >> 5] & b_bit) != 0u) {
                    status = STATUS_NEEDS_EXACT;
                    return;
                }
                first_seen[a >> 5] |= a_bit;
                second_seen[b >> 5] |= b_bit;
                horizon[horizon_count++] = a | (b << 8);
            }
        }

    // Fills holes from the last to the first, so that the vertex that moves into one is alive.
    for (int w = vertex_words - 1; w >= 0; --w)
        for (uint rest = killed[w]; rest != 0u;) {
            const int bit = findMSB(rest), v = 32 * w + bit;
            rest &= ~(1u << bit);
            --vertex_count;
            vertex_x[v] = vertex_x[vertex_count];
            vertex_y[v] = vertex_y[vertex_count];
            vertex_z[v] = vertex_z[vertex_count];
            vertex_error[v] = vertex_error[vertex_count];
            vertex_planes[v] = vertex_planes[vertex_count];
        }

    uint slot = free_plane();
    if (slot == uint(max_planes)) {
        note_planes_in_use();
        slot = free_plane();
        if (slot == uint(max_planes)) {
            status = STATUS_PLANE_OVERFLOW;
            return;
        }
    }
    set_plane(slot, tested, tested_id);
    for (int i = 0; i < horizon_count; ++i) add_vertex(horizon[i] & 0xffu, horizon[i] >> 8, slot);
}

#endif

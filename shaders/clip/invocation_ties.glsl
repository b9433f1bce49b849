// The faces of a finished cell that met ties, in the private memory of an invocation.
#ifndef VOTESS_CLIP_INVOCATION_TIES_GLSL
#define VOTESS_CLIP_INVOCATION_TIES_GLSL

#include "clip/exact_side.glsl"
#include "clip/invocation_cell.glsl"

// Finds the plane of vertex w that vertex v lacks. Returns false when it lacks more than one.
bool find_third_plane(uint v, uint w, out uint third) {
    uint count = 0u;
    for (int i = 0; i < 3; ++i) {
        const uint p = plane_of(w, i);
        if (p == plane_of(v, 0) || p == plane_of(v, 1) || p == plane_of(v, 2)) continue;
        third = p;
        ++count;
    }
    return count == 1u;
}

// Returns the vertices before v that may coincide with it.
void find_near(int v) {
    for (int w = 0; w < vertex_words; ++w) undecided[w] = 0u;
    for (int w = 0; w < v; ++w) {
        const real reach = vertex_error[v] + vertex_error[w];
        if (abs(vertex_x[v] - vertex_x[w]) <= reach && abs(vertex_y[v] - vertex_y[w]) <= reach &&
            abs(vertex_z[v] - vertex_z[w]) <= reach)
            undecided[w >> 5] |= 1u << (w & 31);
    }
}

// Keeps the planes of faces that have at least three edges of positive length. Counts these faces and the distinct
// vertices. The two vertices of an edge coincide when one lies on the third plane of the other.
void keep_true_faces(inout uint faces, inout uint vertices) {
    for (int p = 0; p < max_planes; ++p) horizon[p] = 0u;  // edges of each plane
    for (int v = 0; v < vertex_count; ++v) {
        const uint planes = vertex_planes[v];
        for (int k = 0; k < 3; ++k) ++horizon[plane_of(planes, k)];
        find_near(v);
        for (int w = 0; w < vertex_words; ++w)
            for (uint rest = undecided[w]; rest != 0u; rest &= rest - 1u) {
                const uint other = vertex_planes[32 * w + findLSB(rest)];
                uint third;
                if (!find_third_plane(planes, other, third)) continue;
                const int side = exact_side(plane_id[plane_of(planes, 0)], plane_id[plane_of(planes, 1)],
                                            plane_id[plane_of(planes, 2)], plane_id[third]);
                if (side == side_unknown) status = STATUS_NEEDS_EXACT;
                if (side != 0) continue;
                for (int k = 0; k < 3; ++k) {
                    const uint p = plane_of(planes, k);
                    if (p == plane_of(other, 0) || p == plane_of(other, 1) || p == plane_of(other, 2)) --horizon[p];
                }
            }
    }
    uint edges = 0u;  // each twice
    faces = 0u;
    for (int p = 0; p < max_planes; ++p) {
        if (horizon[p] >= 3u) {
            edges += horizon[p];
            ++faces;
        } else {
            planes_used[p >> 5] &= ~(1u << (p & 31));
        }
    }
    vertices = edges / 2u + 2u - faces;  // Euler
}

#endif

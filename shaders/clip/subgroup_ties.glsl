// The faces of a finished cell of a subgroup that met ties.
#ifndef VOTESS_CLIP_SUBGROUP_TIES_GLSL
#define VOTESS_CLIP_SUBGROUP_TIES_GLSL

#include "clip/exact_side.glsl"
#include "clip/subgroup_cell.glsl"
#include "invocations/subgroup.glsl"
#include "search/subgroup_state.glsl"

// Scratch words behind the list of vertices.
#define EDGE_COUNT(plane) SCRATCH(2u * max_planes + (plane))

// Returns two planes of a vertex, from the k-th on, in this order or the reverse. They are 16 bits apart, because
// NVIDIA's compiler (580.159) takes other bits where two bytes side by side change places.
uint edge_of(uint planes, int k) {
    return plane_of(planes, k) | (plane_of(planes, k == 2 ? 0 : k + 1) << 16);
}
uint reversed_edge_of(uint planes, int k) {
    return plane_of(planes, k == 2 ? 0 : k + 1) | (plane_of(planes, k) << 16);
}

// Keeps in `used` the planes of faces that have at least three edges of positive length. Counts these faces and the
// distinct vertices. The two vertices of an edge coincide when one lies on the third plane of the other.
void keep_true_faces(inout PlaneSet used, out uint faces, out uint vertices) {
    const uint count = list_vertices();
    for (uint p = lane; p < max_planes; p += uint(lanes)) EDGE_COUNT(p) = 0u;
    share();
    bool decided = true;
    for (uint v = lane; v < count; v += uint(lanes)) {
        const uint planes = VERTEX_LIST(v);
        uint thirds = 0u;  // third planes of the other vertices on its three edges
        for (uint w = 0u; w < count; ++w) {
            const uint other = VERTEX_LIST(w);
            for (int k = 0; k < 3; ++k)
                for (int i = 0; i < 3; ++i)
                    if (reversed_edge_of(other, i) == edge_of(planes, k)) thirds |= plane_of(other, (i + 2) % 3) << (8 * k);
        }
        [[dont_unroll]] for (int k = 0; k < 3; ++k) {
            const int side = exact_side(id_of(plane_of(planes, 0)), id_of(plane_of(planes, 1)),
                                        id_of(plane_of(planes, 2)), id_of(plane_of(thirds, k)));
            decided = decided && side != side_unknown;
            if (side != 0) atomicAdd(EDGE_COUNT(plane_of(planes, k)), 1u);
        }
    }
    share();
    uint edges = 0u;
    PlaneSet kept = no_planes;
    for (uint p = lane; p < max_planes; p += uint(lanes))
        if (has(used, p) && EDGE_COUNT(p) >= 3u) {
            edges += EDGE_COUNT(p);
            kept |= set_of(p);
        }
    used = all_bits(kept);
    faces = size_of(used);
    vertices = sum(edges) / 2u + 2u - faces;  // Euler
    if (any_lane(!decided)) status = STATUS_NEEDS_EXACT;
}

#endif

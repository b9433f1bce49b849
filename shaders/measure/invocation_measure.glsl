// Measures a cell in the private memory of an invocation.
#ifndef VOTESS_MEASURE_INVOCATION_MEASURE_GLSL
#define VOTESS_MEASURE_INVOCATION_MEASURE_GLSL

#include "clip/invocation_cell.glsl"
#include "measure/tetrahedra.glsl"

ExactPlane exact_plane[max_planes];
Number area[max_planes];  // when want_geometry is 2

ExactPlane exact_plane_at(uint plane) {
    return exact_plane[plane];
}

void measure_cell() {
    for (int w = 0; w < plane_words; ++w)
        for (uint rest = planes_used[w]; rest != 0u; rest &= rest - 1u) {
            const int p = 32 * w + findLSB(rest);
            area[p] = number(0.0);
            if (plane_id[p] < 0)
                exact_plane[p] = exact_wall(uint(-1 - plane_id[p]));
            else
                exact_plane[p] = exact_bisector(uint(plane_id[p]));
        }
    Moments all = no_moments();
    for (int v = 0; v < vertex_count; ++v) {
        Number areas[3];
        add_corner(vertex_planes[v], all, areas);
        if (want_geometry == 2u)
            for (int k = 0; k < 3; ++k) {
                const uint p = plane_of(vertex_planes[v], k);
                area[p] = plus(area[p], areas[k]);
            }
    }
    conclude(all);
}

#endif

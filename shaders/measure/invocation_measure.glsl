// Measures a cell in the private memory of an invocation.
#ifndef VOTESS_MEASURE_INVOCATION_MEASURE_GLSL
#define VOTESS_MEASURE_INVOCATION_MEASURE_GLSL

#include "clip/invocation_cell.glsl"
#include "measure/corners.glsl"

ExactPlane exact_plane[max_planes];
Number area[max_planes];  // when want_geometry is 2

ExactPlane exact_plane_at(uint plane) {
    return exact_plane[plane];
}
uint planes_of_vertex(uint vertex) {
    return vertex_planes[vertex];
}
#ifndef GEOMETRY_FLOAT64
vec4 refined[max_vertices];
float foot[max_planes];

vec4 plane_in_float32(uint plane) {
    return vec4(rounded(exact_plane[plane].n), rounded(exact_plane[plane].h));
}
vec4 foot_plane_at(uint plane) {
    return vec4(rounded(exact_plane[plane].n), foot[plane]);
}
vec3 place_of_vertex(uint vertex) {
    return refined[vertex].xyz;
}
#endif

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
#ifndef GEOMETRY_FLOAT64
    if (weighted != 0u) {
        middle = vec3(0.0);
        for (int v = 0; v < vertex_count; ++v) middle += vec3(vertex_x[v], vertex_y[v], vertex_z[v]);
        middle /= float(vertex_count);
    }
    for (int v = 0; v < vertex_count; ++v) refined[v] = refined_vertex(vertex_planes[v], all);
    for (int w = 0; w < plane_words; ++w)
        for (uint rest = planes_used[w]; rest != 0u; rest &= rest - 1u) {
            const int p = 32 * w + findLSB(rest);
            foot[p] = near_foot(uint(p), plane_id[p] < 0);
        }
#endif
    for (int v = 0; v < vertex_count; ++v) {
        Number areas[3];
#ifdef GEOMETRY_FLOAT64
        add_corner(uint(v), all, areas);
#else
        add_corner(uint(v), uint(vertex_count), refined[v], all, areas);
#endif
        if (want_geometry == 2u)
            for (int k = 0; k < 3; ++k) {
                const uint p = plane_of(vertex_planes[v], k);
                area[p] = plus(area[p], areas[k]);
            }
    }
    conclude(all);
}

#endif

// Measures a cell of a subgroup. A lane measures at its vertices; the sums are over all lanes. The store of candidates,
// which is free by now, holds the planes in the precision of the measures.
#ifndef VOTESS_MEASURE_SUBGROUP_MEASURE_GLSL
#define VOTESS_MEASURE_SUBGROUP_MEASURE_GLSL

#include "clip/subgroup_cell.glsl"
#include "invocations/subgroup.glsl"
#include "measure/corners.glsl"
#include "search/subgroup_state.glsl"

// The numbers of planes are in the store and behind it: all first words, then all second ones.
Number get_number(uint i) {
    return of_words(uvec2(WORD((i)), WORD(4u * max_planes + (i))));
}
void put_number(uint i, Number number) {
    const uvec2 both = words_of(number);
    WORD((i)) = both.x;
    WORD(4u * max_planes + (i)) = both.y;
}

void share_exact_planes(PlaneSet used) {
    share();
    for (uint p = lane; p < max_planes; p += uint(lanes)) {
        if (!has(used, p)) continue;
        const int id = id_of(p);
        ExactPlane plane;
        if (id < 0)
            plane = exact_wall(uint(-1 - id));
        else
            plane = exact_bisector(uint(id));
        put_number(p, plane.n.x);
        put_number(p + max_planes, plane.n.y);
        put_number(p + 2u * max_planes, plane.n.z);
#ifdef GEOMETRY_FLOAT64
        put_number(p + 3u * max_planes, plane.foot);
#else
        put_number(p + 3u * max_planes, plane.h);
#endif
    }
    share();
}

uint planes_of_vertex(uint vertex) {
    return VERTEX_LIST(vertex);
}

ExactPlane exact_plane_at(uint p) {
    return ExactPlane(
        Vector(get_number(p), get_number(p + max_planes), get_number(p + 2u * max_planes)),
        get_number(p + 3u * max_planes));
}

#ifndef GEOMETRY_FLOAT64
// The vertices replace the second words of planes, and are in scratch memory behind their list; feet replace h.
vec3 place_of_vertex(uint vertex) {
    return uintBitsToFloat(uvec3(WORD(4u * max_planes + vertex), WORD(6u * max_planes + vertex),
                                 SCRATCH(2u * max_planes + vertex)));
}
vec4 plane_in_float32(uint p) {
    return uintBitsToFloat(uvec4(WORD((p)), WORD(max_planes + p), WORD(2u * max_planes + p), WORD(3u * max_planes + p)));
}
vec4 foot_plane_at(uint p) {
    return plane_in_float32(p);
}

vec4 refined[slots];  // this lane's vertices

void refine_vertices(PlaneSet used, uint vertices, inout Moments all) {
    if (weighted != 0u) {
        middle = vec3(0.0);
        [[unroll]] for (int s = 0; s < slots; ++s)
            if (vertex_planes[s] != 0u) middle += vec3(vertex_x[s], vertex_y[s], vertex_z[s]);
        middle = vec3(sum(middle.x), sum(middle.y), sum(middle.z)) / float(vertices);
    }
    [[dont_unroll]] for (uint first = 0u; first < vertices; first += uint(lanes)) {
        vec4 vertex = vec4(0.0);
        if (first + lane < vertices) vertex = refined_vertex(VERTEX_LIST(first + lane), all);
        [[unroll]] for (int s = 0; s < slots; ++s)
            if (first == uint(s * lanes)) refined[s] = vertex;
    }
    float foot[planes_of_lane];
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) {
        const uint p = uint(i * lanes) + lane;
        foot[i] = p < max_planes && has(used, p) ? near_foot(p, id_of(p) < 0) : 0.0;
    }
    share();
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const uint i = uint(s * lanes) + lane;
        if (i >= vertices) continue;
        WORD(4u * max_planes + i) = floatBitsToUint(refined[s].x);
        WORD(6u * max_planes + i) = floatBitsToUint(refined[s].y);
        SCRATCH(2u * max_planes + i) = floatBitsToUint(refined[s].z);
    }
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) {
        const uint p = uint(i * lanes) + lane;
        if (p < max_planes) WORD(3u * max_planes + p) = floatBitsToUint(foot[i]);
    }
    share();
}
#endif

Number area_of(uint plane) {
    return get_number(plane);
}

// The areas replace the planes afterwards.
void measure_cell(PlaneSet used, uint vertices) {
    share_exact_planes(used);
    list_vertices();
    Moments all = no_moments();
    Number areas_of_lane[planes_of_lane];
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) areas_of_lane[i] = number(0.0);
#ifndef GEOMETRY_FLOAT64
    refine_vertices(used, vertices, all);
#endif
    for (uint first = 0u; first < vertices; first += uint(lanes)) {
        Number parts[3];
        uint planes = 0xffffffu;  // none
        if (first + lane < vertices) {
            planes = VERTEX_LIST(first + lane);
#ifdef GEOMETRY_FLOAT64
            add_corner(first + lane, all, parts);
#else
            vec4 corner = vec4(0.0);
            [[unroll]] for (int s = 0; s < slots; ++s)
                if (first == uint(s * lanes)) corner = refined[s];
            add_corner(first + lane, vertices, corner, all, parts);
#endif
        }
        if (want_geometry != 2u) continue;
        for (PlaneSet rest = used; !is_empty(rest); rest = without_lowest(rest)) {
            const uint p = lowest_of(rest);
            Number mine = number(0.0);
            for (int k = 0; k < 3; ++k)
                if (plane_of(planes, k) == p) mine = parts[k];
            const Number area = sum(mine);
            [[unroll]] for (int i = 0; i < planes_of_lane; ++i)
                if (p == uint(i * lanes) + lane) areas_of_lane[i] = plus(areas_of_lane[i], area);
        }
    }
    all.sum = sum(all.sum);
#ifdef GEOMETRY_FLOAT64
    all.first = Vector(sum(all.first.x), sum(all.first.y), sum(all.first.z));
#else
    const vec3 first = rounded(all.first);
    all.first = vector(vec3(sum_in_pairs(first.x), sum_in_pairs(first.y), sum_in_pairs(first.z)));
#endif
    all.error = sum(all.error);
    if (want_geometry == 2u) all.area_error = sum(all.area_error);
    all.farthest = largest(all.farthest);
#ifndef GEOMETRY_FLOAT64
    all.extent = weighted != 0u ? largest(all.extent) : all.farthest;
#endif
    conclude(all);
    if (want_geometry != 2u) return;
    share();
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) {
        const uint p = uint(i * lanes) + lane;
        if (p < max_planes) put_number(p, areas_of_lane[i]);
    }
    share();
}

#endif

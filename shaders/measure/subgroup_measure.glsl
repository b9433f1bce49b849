// Measures a cell of a subgroup. A lane measures at its vertices; the sums are over all lanes. The store of candidates,
// which is free by now, holds the planes in the precision of the measures.
#ifndef VOTESS_MEASURE_SUBGROUP_MEASURE_GLSL
#define VOTESS_MEASURE_SUBGROUP_MEASURE_GLSL

#include "clip/subgroup_cell.glsl"
#include "invocations/subgroup.glsl"
#include "measure/tetrahedra.glsl"
#include "search/subgroup_state.glsl"

// A number has two words, SUBGROUP_PLANES apart, in an array of the store.
#define FIRST_WORD(array, i) array[SUBGROUP_STORE * SUBGROUP + (i)]
#define SECOND_WORD(array, i) array[SUBGROUP_STORE * SUBGROUP + (i) + SUBGROUP_PLANES]
#define GET_NUMBER(array, i) of_words(uvec2(FIRST_WORD(array, i), SECOND_WORD(array, i)))
#define PUT_NUMBER(array, i, number)           \
    {                                          \
        const uvec2 words = words_of(number);  \
        FIRST_WORD(array, i) = words.x;        \
        SECOND_WORD(array, i) = words.y;       \
    }
const uint second_number = 2u * SUBGROUP_PLANES;  // each array of the store holds two numbers of a plane
const int planes_of_lane = (SUBGROUP_PLANES + lanes - 1) / lanes;

void share_exact_planes(uint used) {
    share();
    for (uint p = lane; p < SUBGROUP_PLANES; p += uint(lanes)) {
        if (((used >> p) & 1u) == 0u) continue;
        const int id = id_of(p);
        ExactPlane plane;
        if (id < 0)
            plane = exact_wall(uint(-1 - id));
        else
            plane = exact_bisector(uint(id));
        PUT_NUMBER(candidate_key, p, plane.n.x)
        PUT_NUMBER(candidate_key, p + second_number, plane.n.y)
        PUT_NUMBER(candidate_seed, p, plane.n.z)
        PUT_NUMBER(candidate_seed, p + second_number, plane.foot)
    }
    share();
}

ExactPlane exact_plane_at(uint p) {
    return ExactPlane(Vector(GET_NUMBER(candidate_key, p), GET_NUMBER(candidate_key, p + second_number),
                             GET_NUMBER(candidate_seed, p)),
                      GET_NUMBER(candidate_seed, p + second_number));
}

Number area_of(uint plane) {
    return GET_NUMBER(candidate_key, plane);
}

// The areas replace the planes afterwards.
void measure_cell(uint used, uint vertices) {
    share_exact_planes(used);
    list_vertices();
    Moments all = no_moments();
    Number areas_of_lane[planes_of_lane];
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) areas_of_lane[i] = number(0.0);
    for (uint first = 0u; first < vertices; first += uint(lanes)) {
        Number parts[3];
        uint planes = 0xffffffu;  // none
        if (first + lane < vertices) {
            planes = VERTEX_LIST(first + lane);
            add_corner(planes, all, parts);
        }
        if (want_geometry != 2u) continue;
        for (uint rest = used; rest != 0u; rest &= rest - 1u) {
            const uint p = uint(findLSB(rest));
            Number mine = number(0.0);
            for (int k = 0; k < 3; ++k)
                if (plane_of(planes, k) == p) mine = parts[k];
            const Number area = sum(mine);
            [[unroll]] for (int i = 0; i < planes_of_lane; ++i)
                if (p == uint(i * lanes) + lane) areas_of_lane[i] = plus(areas_of_lane[i], area);
        }
    }
    all.sum = sum(all.sum);
    all.first = Vector(sum(all.first.x), sum(all.first.y), sum(all.first.z));
    all.error = sum(all.error);
    all.farthest = largest(all.farthest);
    conclude(all);
    if (want_geometry != 2u) return;
    share();
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) {
        const uint p = uint(i * lanes) + lane;
        if (p < SUBGROUP_PLANES) PUT_NUMBER(candidate_key, p, areas_of_lane[i])
    }
    share();
}

#endif

// Sets of planes of a cell, one bit each. The first tier has SUBGROUP_PLANES planes, a word. Shaders that clip in float64,
// or are compiled with SECOND_TIER, have twice as many, two words.
#ifndef VOTESS_CLIP_PLANE_SET_GLSL
#define VOTESS_CLIP_PLANE_SET_GLSL

#include "invocations/subgroup.glsl"
#include "shared/config.h"

#if defined(CLIP_FLOAT64) || defined(SECOND_TIER)
#define TWO_WORDS_OF_PLANES
#define PlaneSet uvec2
const uint max_planes = 2u * SUBGROUP_PLANES;
const PlaneSet no_planes = PlaneSet(0u), all_planes = PlaneSet(0xffffffffu);

PlaneSet set_of(uint plane) {
    return plane < 32u ? uvec2(1u << plane, 0u) : uvec2(0u, 1u << (plane - 32u));
}

bool is_empty(PlaneSet planes) {
    return (planes.x | planes.y) == 0u;
}

uint size_of(PlaneSet planes) {
    return uint(bitCount(planes.x) + bitCount(planes.y));
}

uint lowest_of(PlaneSet planes) {
    return uint(planes.x != 0u ? findLSB(planes.x) : 32 + findLSB(planes.y));
}

uint highest_of(PlaneSet planes) {
    return uint(planes.y != 0u ? 32 + findMSB(planes.y) : findMSB(planes.x));
}

PlaneSet without_lowest(PlaneSet planes) {
    return planes.x != 0u ? uvec2(planes.x & (planes.x - 1u), planes.y) : uvec2(0u, planes.y & (planes.y - 1u));
}

// Returns the planes behind the only one of a set; none where that is empty.
PlaneSet planes_behind(PlaneSet one) {
    return uvec2(~(one.x | (one.x - 1u)), one.x != 0u ? 0xffffffffu : ~(one.y | (one.y - 1u)));
}

PlaneSet all_bits(PlaneSet planes) {
    return uvec2(all_bits(planes.x), all_bits(planes.y));
}

// Returns how many planes of the set are before this one.
uint rank_in(PlaneSet planes, uint plane) {
    const uint before = (1u << (plane & 31u)) - 1u;
    return plane < 32u ? uint(bitCount(planes.x & before)) : uint(bitCount(planes.x) + bitCount(planes.y & before));
}

#else

#define PlaneSet uint
const uint max_planes = SUBGROUP_PLANES;
const PlaneSet no_planes = 0u, all_planes = 0xffffffffu;

PlaneSet set_of(uint plane) {
    return 1u << plane;
}

bool is_empty(PlaneSet planes) {
    return planes == 0u;
}

uint size_of(PlaneSet planes) {
    return uint(bitCount(planes));
}

uint lowest_of(PlaneSet planes) {
    return uint(findLSB(planes));
}

uint highest_of(PlaneSet planes) {
    return uint(findMSB(planes));
}

PlaneSet without_lowest(PlaneSet planes) {
    return planes & (planes - 1u);
}

PlaneSet planes_behind(PlaneSet one) {
    return ~(one | (one - 1u));
}

uint rank_in(PlaneSet planes, uint plane) {
    return uint(bitCount(planes & ((1u << plane) - 1u)));
}

#endif

bool has(PlaneSet planes, uint plane) {
    return !is_empty(planes & set_of(plane));
}

#endif

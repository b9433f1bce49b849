// How far a place lies within a wall of any direction, n.x = d with |n| = 1 (WallPlane in shared/layout.h).
//
// The distance d - n.x cancels, so it is taken from whole numbers: n is right to 2^-63 an axis, which with coordinates below
// 2^62 changes n.x by at most 1.5 units; the distance is rounded to half a unit; and coordinates that were rounded down
// change it by sqrt(3) units. That is less than MAX_WALL_ERROR together.
#ifndef VOTESS_CLIP_WALL_DISTANCE_GLSL
#define VOTESS_CLIP_WALL_DISTANCE_GLSL

#include "numbers/int128.glsl"
#include "numbers/int64.glsl"
#include "shared/layout.h"

// In 2^-WALL_BITS units, and half a unit more. It is negative beyond the wall.
uvec4 fine_wall_distance(WallPlane wall, uvec2 x, uvec2 y, uvec2 z) {
    const uvec2 p[3] = uvec2[3](x, y, z);
    uvec4 sum = uvec4(wall.offset[0], wall.offset[1]);
    for (int k = 0; k < 3; ++k) {
        const uvec4 product = product128(magnitude64(wall.normal[k]), p[k]);
        sum = add128(sum, is_negative(wall.normal[k]) ? product : negate128(product));
    }
    return sum;
}

// In units, of one that is below 2^64.
uvec2 whole_wall_distance(uvec4 fine) {
    return uvec2((fine.y >> WALL_BITS - 32) | (fine.z << 64 - WALL_BITS),
                 (fine.z >> WALL_BITS - 32) | (fine.w << 64 - WALL_BITS));
}

vec3 rough_place(uvec2 x, uvec2 y, uvec2 z) {
    return vec3(float(x.y), float(y.y), float(z.y)) * 4294967296.0;
}

// At most the distance, in units: low words are less than 2^32 each, conversions, products and sums of numbers below 2^64
// err by less than 2^45 altogether.
float min_wall_distance(WallPlane wall, vec3 place) {
    return wall.rough[3] - dot(vec3(wall.rough[0], wall.rough[1], wall.rough[2]), place) - 3.5184372e13;
}

#endif

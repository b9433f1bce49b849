// The distance of a place from a wall of any direction, n.x = d with |n| = 1 (WallPlane in shared/layout.h).
//
// The distance d - n.x cancels, so it is computed in whole numbers. It has three errors. n is right to 2^-63 an axis,
// which with coordinates of centers, between -2^59 and 2^62 + 2^59, changes n.x by at most 1.7 units. The distance is
// rounded to half a unit. Coordinates that were rounded down change it by sqrt(3) units. The sum is less than
// MAX_WALL_ERROR.
#ifndef VOTESS_CLIP_WALL_DISTANCE_GLSL
#define VOTESS_CLIP_WALL_DISTANCE_GLSL

#include "numbers/int128.glsl"
#include "numbers/int64.glsl"
#include "shared/layout.h"

// Returns the distance in 2^-WALL_BITS units, plus half a unit. It is negative beyond the wall.
uvec4 fine_wall_distance(WallPlane wall, uvec2 x, uvec2 y, uvec2 z) {
    const uvec2 p[3] = uvec2[3](x, y, z);
    uvec4 sum = uvec4(wall.offset[0], wall.offset[1]);
    for (int k = 0; k < 3; ++k) {
        const uvec4 product = product128(magnitude64(wall.normal[k]), magnitude64(p[k]));
        sum = add128(sum, is_negative(wall.normal[k]) != is_negative(p[k]) ? product : negate128(product));
    }
    return sum;
}

// Returns a distance between -2^63 and 2^63 in units.
uvec2 whole_wall_distance(uvec4 fine) {
    return uvec2((fine.y >> WALL_BITS - 32) | (fine.z << 64 - WALL_BITS),
                 (fine.z >> WALL_BITS - 32) | (fine.w << 64 - WALL_BITS));
}

vec3 rough_place(uvec2 x, uvec2 y, uvec2 z) {
    return vec3(int(x.y), int(y.y), int(z.y)) * 4294967296.0;
}

// Returns a lower bound of the distance, in units. Low words are less than 2^32 each; conversions, products and sums of
// numbers below 2^64 err by less than 2^45 together.
float min_wall_distance(WallPlane wall, vec3 place) {
    return wall.rough[3] - dot(vec3(wall.rough[0], wall.rough[1], wall.rough[2]), place) - 3.5184372e13;
}

#endif

// Walls of any direction, n.x = d with |n| = 1 (WallPlane in shared/layout.h).
//
// The seed's distance d - n.p cancels, so it is taken from whole numbers: n is right to 2^-63 an axis, which with
// coordinates below 2^62 changes n.p by at most 1.5 units; the distance is rounded to half a unit; and coordinates that
// were rounded down change it by sqrt(3) units. Those are less than the 4 units that `quantum` has in a run with walls.
// As the seed lies within its walls, a distance below 0 is 0.
#ifndef VOTESS_CLIP_WALLS_GLSL
#define VOTESS_CLIP_WALLS_GLSL

#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "numbers/int128.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(constant_id = CONSTANT_WALLS) const uint has_walls = 0u;
layout(std430, binding = BINDING_RUN_STATE) readonly buffer State {
    RunState state;
    WallPlane walls[];
};

// The box's faces are planes -1 .. -6 of a cell; where there are walls it is larger than the domain, and wall w, which rows
// list as -1 - w, is plane -7 - w.
//
// Faces of the domain's box are cut off last: a polyhedron that touches the box has edges through its corners, which then
// are gone from all cells.
const int first_wall = -7;
const float wall_step = 2.1684043449710089e-19;  // 2^-WALL_BITS

uint wall_in_turn(uint i) {
    const uint count = uint(walls.length());
    return i + 6u < count ? i + 6u : i + 6u - count;
}

bool is_negative(uvec2 a) {
    return (a.y & 0x80000000u) != 0u;
}

uvec2 magnitude64(uvec2 a) {
    return is_negative(a) ? negate64(a) : a;
}

// In units.
uvec2 wall_distance(WallPlane wall) {
    const uvec2 p[3] = uvec2[3](px, py, pz);
    uvec4 sum = uvec4(wall.offset[0], wall.offset[1]);
    for (int k = 0; k < 3; ++k) {
        const uvec4 product = product128(magnitude64(wall.normal[k]), p[k]);
        sum = add128(sum, is_negative(wall.normal[k]) ? product : negate128(product));
    }
    if (is_negative(sum.zw)) return uvec2(0);
    return uvec2((sum.y >> WALL_BITS - 32) | (sum.z << 64 - WALL_BITS), (sum.z >> WALL_BITS - 32) | (sum.w << 64 - WALL_BITS));
}

real wall_number(uvec2 m) {
#ifdef CLIP_FLOAT64
    return real(m.y) * 4294967296.0LF + real(m.x);
#else
    return round64(m);
#endif
}

Plane wall_plane(uint w) {
    const WallPlane wall = walls[w];
    real n[3];
    for (int k = 0; k < 3; ++k) {
        const real size = wall_number(magnitude64(wall.normal[k])) * real(wall_step);
        n[k] = is_negative(wall.normal[k]) ? -size : size;
    }
    const real distance = wall_number(wall_distance(wall)) * real(scale);
    return Plane(n[0], n[1], n[2], distance, real(1), distance);
}

vec3 rough_place() {
    return vec3(float(px.y), float(py.y), float(pz.y)) * 4294967296.0;
}

// At most the distance, in units of the cell, of a seed at this place: low words are less than 2^32 each, conversions,
// products and sums of numbers below 2^64 err by less than 2^45 altogether.
float least_wall_distance(uint w, vec3 place) {
    const vec3 n = vec3(walls[w].rough[0], walls[w].rough[1], walls[w].rough[2]);
    return (walls[w].rough[3] - dot(n, place) - 3.5184372e13) * scale;
}

// Whether a plane is a face of the box beyond walls, which a cell cannot have.
bool is_no_wall(int id) {
    return has_walls != 0u && id < 0 && id > first_wall;
}

int listed_wall(int id) {
    return has_walls != 0u ? id - first_wall - 1 : id;
}

#endif

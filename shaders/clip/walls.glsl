// Walls of any direction as planes of a cell. The center's distance is right to less than MAX_WALL_ERROR, which `quantum`
// includes in a run with walls (clip/wall_distance.glsl). A center that is not the seed may lie beyond a wall; the seed
// lies within its walls, so a distance below 0 becomes 0.
#ifndef VOTESS_CLIP_WALLS_GLSL
#define VOTESS_CLIP_WALLS_GLSL

#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "clip/wall_distance.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(constant_id = CONSTANT_WALLS) const uint has_walls = 0u;
layout(std430, binding = BINDING_RUN_STATE) readonly buffer State {
    RunState state;
    WallPlane walls[];
};

// The box's faces are planes -1 .. -6 of a cell. Where there are walls the box is larger than the domain, and wall w,
// which rows list as -1 - w, is plane -7 - w.
//
// Faces of the domain's box cut last. A polyhedron that touches the box has edges through its corners; its walls have
// then removed the corners from all cells.
const int first_wall = -7;
const float wall_step = 2.1684043449710089e-19;  // 2^-WALL_BITS

uint wall_in_turn(uint i) {
    const uint count = uint(walls.length());
    return i + 6u < count ? i + 6u : i + 6u - count;
}

// In units, in two's complement.
uvec2 wall_distance(WallPlane wall) {
    const uvec4 fine = fine_wall_distance(wall, cx, cy, cz);
    return is_negative(fine.zw) && !is_tilted ? uvec2(0) : whole_wall_distance(fine);
}

real wall_number(uvec2 a) {
    const real size = round_weight(magnitude64(a));
    return is_negative(a) ? -size : size;
}

Plane wall_plane(uint w) {
    const WallPlane wall = walls[w];
    real n[3];
    for (int k = 0; k < 3; ++k) n[k] = wall_number(wall.normal[k]) * real(wall_step);
    const real distance = wall_number(wall_distance(wall)) * real(scale);
    return Plane(n[0], n[1], n[2], distance, real(1), abs(distance));
}

vec3 rough_place() {
    return rough_place(cx, cy, cz);
}

// Returns a lower bound of the distance, in units of the cell, of a center at this place.
float min_wall_distance(uint w, vec3 place) {
    return min_wall_distance(walls[w], place) * scale;
}

// Returns whether a plane is a face of the box beyond walls, which no cell has.
bool is_no_wall(int id) {
    return has_walls != 0u && id < 0 && id > first_wall;
}

int listed_wall(int id) {
    return has_walls != 0u ? id - first_wall - 1 : id;
}

#endif

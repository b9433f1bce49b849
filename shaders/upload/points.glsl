// Coordinates of all points in input order, in units, and their weights (see WEIGHT_BITS). The .comp declares `push`, with
// total, before.
#ifndef VOTESS_UPLOAD_POINTS_GLSL
#define VOTESS_UPLOAD_POINTS_GLSL

#include "shared/interface.h"
#include "shared/layout.h"

layout(std430, binding = BINDING_POINTS) buffer Points { uvec2 points[]; };

uvec2 point_x(uint point) {
    return points[point];
}
uvec2 point_y(uint point) {
    return points[push.total + point];
}
uvec2 point_z(uint point) {
    return points[2u * push.total + point];
}
uvec2 point_weight(uint point) {
    return points[3u * push.total + point];
}

void put_point(uint point, uvec2 x, uvec2 y, uvec2 z) {
    points[point] = x;
    points[push.total + point] = y;
    points[2u * push.total + point] = z;
}
void put_weight(uint point, uvec2 weight) {
    points[3u * push.total + point] = weight;
}

// Leaves the place without a seed.
void put_none(uint point) {
    put_point(point, uvec2(NO_COORDINATE), uvec2(NO_COORDINATE), uvec2(NO_COORDINATE));
}

#endif

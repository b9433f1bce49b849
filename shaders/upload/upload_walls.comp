// upload: removes the coordinates of seeds that lie beyond a wall of any direction. Where rounding does not allow to
// decide, no cell is certified.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "clip/wall_distance.glsl"
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { UploadPush push; };
layout(std430, binding = BINDING_RUN_STATE) buffer State {
    RunState state;
    WallPlane walls[];
};

#include "upload/points.glsl"

void main() {
    const uint point = linear_invocation();
    if (point >= push.count) return;
    const uvec2 x = point_x(point), y = point_y(point), z = point_z(point);
    if (x.y == NO_COORDINATE) return;
    const vec3 place = rough_place(x, y, z);
    bool beyond = false, unsure = false;
    // The first six are the faces of the box, which upload compared with the coordinates as given.
    for (uint w = 6u; w < uint(walls.length()) && !beyond; ++w) {
        if (min_wall_distance(walls[w], place) > 0.0) continue;
        const uvec4 fine = fine_wall_distance(walls[w], x, y, z);
        const bool negative = is_negative(fine.zw);
        if (!less64(whole_wall_distance(negative ? negate128(fine) : fine), uvec2(MAX_WALL_ERROR, 0u)))
            beyond = negative;
        else
            unsure = true;
    }
    if (beyond)
        put_none(point);
    else if (unsure)
        atomicOr(state.incomplete, 1u);
}

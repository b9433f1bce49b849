// picture_fill: places corners of triangles in space or, with another matrix, on the picture. With PLACE_ONLY that is all
// it does.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/picture.h"

layout(push_constant) uniform Push { PicturePush push; };

layout(location = 0) in vec3 position;
#ifndef PLACE_ONLY
layout(location = 1) in vec4 normal;
layout(location = 2) in vec4 color;
layout(location = 3) in float edge;

layout(location = 0) flat out vec3 out_normal;
layout(location = 1) flat out vec4 out_color;
layout(location = 2) out float out_edge;
#endif

void main() {
    const vec4 clip = push.matrix[0] * position.x + push.matrix[1] * position.y + push.matrix[2] * position.z +
                      push.matrix[3];
    gl_Position = vec4(clip.xy * push.tile.xy + push.tile.zw * clip.w, clip.zw);
#ifndef PLACE_ONLY
    out_normal = normal.xyz;
    out_color = color;
    out_edge = edge;
#endif
}

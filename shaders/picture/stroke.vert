// picture_stroke: makes a rectangle around each line; an instance is a line.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/picture.h"

layout(push_constant) uniform Push { PicturePush push; };

layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in float half_width;
layout(location = 3) in vec4 color;

layout(location = 0) flat out vec4 out_color;
layout(location = 1) flat out float out_half_width;
layout(location = 2) flat out float out_length;
layout(location = 3) out vec2 out_place;  // along and beside the line, pixels

void main() {
    const vec2 line = to.xy - from.xy;
    const float size = length(line);
    const vec2 along = size > 0.0 ? line / size : vec2(1.0, 0.0);
    const bool far = gl_VertexIndex == 1 || gl_VertexIndex == 3 || gl_VertexIndex == 4;
    const bool above = gl_VertexIndex == 2 || gl_VertexIndex == 4 || gl_VertexIndex == 5;
    const float margin = half_width + 1.0;
    out_place = vec2(far ? size + margin : -margin, above ? margin : -margin);
    out_length = size;
    out_half_width = half_width;
    out_color = color;
    const vec2 place = from.xy + along * out_place.x + vec2(-along.y, along.x) * out_place.y;
    const vec4 at = vec4(place, far ? to.z : from.z, 1.0);
    const vec2 clip = at.x * push.matrix[0].xy + at.y * push.matrix[1].xy + push.matrix[3].xy;
    gl_Position = vec4(clip * push.tile.xy + push.tile.zw, at.zw);
}

// picture_depth: writes the normal of the surface in a pixel and its distance, from which occlusion is computed.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/picture.h"

layout(push_constant) uniform Push { PicturePush push; };
layout(location = 0) out vec4 surface;

void main() {
    const float away = 1.0 / gl_FragCoord.w;
    const vec3 place = vec3((gl_FragCoord.xy - push.lens.xy) * away / push.lens.z, away);
    const vec3 normal = cross(dFdx(place), dFdy(place));
    const float size = length(normal);
    // Towards the camera, which looks along z.
    const vec3 facing = dot(normal, place) > 0.0 ? -normal : normal;
    surface = vec4(size > 0.0 ? facing / size : vec3(0.0, 0.0, -1.0), away);
}

// Carries each seed along a swirling flow without sources, so that the density of seeds is only stirred. Its stream
// functions vanish on the walls of the unit box; what rounding and the seeds' own flutter carry beyond is reflected.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "push.h"

layout(local_size_x = 64) in;
layout(push_constant) uniform Push { MovePush push; };
layout(std430, binding = 0) readonly buffer Source { vec4 source[]; };  // w: the seed's own phase
layout(std430, binding = 1) writeonly buffer Target { vec4 target[]; };

const float PI = 3.14159265;

vec3 flow(vec3 p, float phase, float time) {
    const vec3 s = sin(PI * p), c = cos(PI * p);
    // One vortex around the vertical axis, and two rolls that come and go.
    vec3 v = vec3(s.x * c.y, -c.x * s.y, 0.0);
    const float roll = 0.5 * sin(time);
    v += roll * vec3(2.0 * s.x * c.x * c.z, 0.0, -2.0 * cos(2.0 * PI * p.x) * s.z);
    return v + 0.04 * sin(vec3(3.0, 4.0, 5.0) * time + vec3(1.0, 2.0, 3.0) * phase);
}

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const vec4 seed = source[i];
    const vec3 middle = seed.xyz + 0.5 * push.step * flow(seed.xyz, seed.w, push.time - 0.5 * push.step);
    vec3 p = seed.xyz + push.step * flow(middle, seed.w, push.time);
    p = 1.0 - abs(1.0 - abs(p));
    target[i] = vec4(clamp(p, 0.0, 1.0), seed.w);
}

// The simulation of this example: each seed circles around a place of its own, one in each cube of a lattice.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Seeds { vec4 seeds[]; };

// Scatters the bits of n, and moves on to the next number: in [0, 1).
float random(inout uint n) {
    for (int i = 0; i < 3; ++i) n = (n ^ (n >> 13)) * 1664525u + 1013904223u;
    return float(n >> 8) / 16777216.0;
}

void main() {
    const uint i = gl_GlobalInvocationID.x, side = push.side;
    if (i >= side * side * side) return;
    uint state = i;
    const vec3 home = vec3(i % side, i / side % side, i / (side * side)) +
                      vec3(random(state), random(state), random(state));
    const vec3 phase = 6.2832 * vec3(random(state), random(state), random(state));
    const vec3 way = 0.6 * sin(phase + push.time * vec3(0.7, 0.9, 0.8));
    seeds[i] = vec4(clamp((home + way) / float(side), 0.0, 1.0), 0.0);
}

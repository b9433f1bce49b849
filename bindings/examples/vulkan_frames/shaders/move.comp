// The simulation of this example: a flow without sources carries the seeds through the unit box.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "push.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Seeds { vec4 seeds[]; };  // w: the seed's own phase

const float PI = 3.14159265;

// Returns a number in [0, 1) and advances the state (PCG).
float random(inout uint state) {
    state = state * 747796405u + 2891336453u;
    const uint word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
    return float((word >> 22 ^ word) >> 8) / 16777216.0;
}

// Places half of the seeds anywhere in the box, half around a ring.
vec4 first_place(uint i) {
    uint state = i;
    vec3 p = vec3(random(state), random(state), random(state));
    if (i % 2 == 1) {
        const float turn = 2.0 * PI * p.x;
        // The sum of two random numbers makes the middle of the ring denser.
        const vec3 a = vec3(random(state), random(state), random(state));
        const vec3 b = vec3(random(state), random(state), random(state));
        p = vec3(0.5 + 0.27 * cos(turn), 0.5 + 0.27 * sin(turn), 0.6) + 0.36 * (a + b - 1.0);
    }
    return vec4(clamp(p, 0.0, 1.0), 2.0 * PI * random(state));
}

// Returns the velocity: one vortex around the vertical axis, two rolls that come and go, and the seed's own flutter.
vec3 flow(vec3 p, float phase, float time) {
    const vec3 s = sin(PI * p), c = cos(PI * p);
    const float roll = 0.5 * sin(time);
    return vec3(s.x * c.y, -c.x * s.y, 0.0) +
           roll * vec3(2.0 * s.x * c.x * c.z, 0.0, -2.0 * cos(2.0 * PI * p.x) * s.z) +
           0.04 * sin(vec3(3.0, 4.0, 5.0) * time + vec3(1.0, 2.0, 3.0) * phase);
}

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    if (push.step == 0.0) {
        seeds[i] = first_place(i);
        return;
    }
    const vec4 seed = seeds[i];
    const vec3 halfway = seed.xyz + 0.5 * push.step * flow(seed.xyz, seed.w, push.time - push.step);
    vec3 p = seed.xyz + push.step * flow(halfway, seed.w, push.time - 0.5 * push.step);
    p = 1.0 - abs(1.0 - abs(p));  // the walls reflect
    seeds[i] = vec4(clamp(p, 0.0, 1.0), seed.w);
}

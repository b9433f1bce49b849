// Runs shaders/clip/exact_side.glsl on cases: five seeds each, the cell's first, and the ids of its planes.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/interface.h"

struct TiesPush {
    uvec2 extent[3];
    uint seed_count;  // five a case
};
layout(push_constant) uniform Push { TiesPush push; };

#include "clip/exact_side.glsl"
#include "invocations/index.glsl"

layout(std430, binding = BINDING_SEED_INPUT) readonly buffer Planes { ivec4 planes[]; };
layout(std430, binding = BINDING_CHUNK) writeonly buffer Sides { int sides[]; };

void main() {
    const uint number = linear_invocation();
    if (5u * number >= push.seed_count) return;
    px = seed_x(5u * number);
    py = seed_y(5u * number);
    pz = seed_z(5u * number);
    quantum = real(0);
    const ivec4 ids = planes[number];
    sides[number] = exact_side(ids.x, ids.y, ids.z, ids.w);
}

// kept: notes where each point is among the sorted seeds.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { KeptPush push; };
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_PLACES) writeonly buffer Places { uint places[]; };

void main() {
    const uint seed = linear_invocation();
    if (seed < push.cell_count) places[seed_input[seed] & INDEX_MASK] = seed;
}

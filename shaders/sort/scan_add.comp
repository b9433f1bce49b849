// Adds to each block of TILE_ITEMS the sum of the blocks before it.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { ScanPush push; };
layout(std430, binding = BINDING_SCAN_DATA) buffer Data { uint data[]; };
layout(std430, binding = BINDING_SCAN_SUMS) readonly buffer Sums { uint block_sums[]; };

void main() {
    const uint i = linear_invocation();
    if (i < push.count) data[i] += block_sums[i / TILE_ITEMS];
}

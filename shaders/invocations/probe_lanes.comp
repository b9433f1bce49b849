// Writes the size of the subgroup that each invocation is in, and 0 where some of its lanes are missing.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { ScanPush push; };
layout(std430, binding = BINDING_SCAN_DATA) writeonly buffer Sizes { uint sizes[]; };

void main() {
    const uint i = linear_invocation();
    const bool is_full = subgroupBallotBitCount(subgroupBallot(true)) == gl_SubgroupSize;
    if (i < push.count) sizes[i] = is_full ? gl_SubgroupSize : 0u;
}

// sort: finds out whether a block of the curve holds more seeds than a group of the hierarchy. Seeds within a block
// have no order, so a box of some of them would be as large as the block.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { KeyPush push; };
layout(std430, binding = BINDING_KEYS_IN) readonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = BINDING_SCAN_DATA) buffer Crowded { uint crowded; };

void main() {
    const uint seed = linear_invocation();
    if (seed < push.total && seed >= GROUP_SEEDS && keys[seed] == keys[seed - GROUP_SEEDS]) atomicOr(crowded, 1u);
}

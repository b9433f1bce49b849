// Makes exclusive prefix sums inside blocks of TILE_ITEMS, in place, and each block's total.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"
#include "sort/scan_tile.glsl"

layout(push_constant) uniform Push { ScanPush push; };
layout(std430, binding = BINDING_SCAN_DATA) buffer Data { uint data[]; };
layout(std430, binding = BINDING_SCAN_SUMS) writeonly buffer Sums { uint block_sums[]; };

void main() {
    const uint block = linear_group();
    const uint me = gl_LocalInvocationID.x;
    const uint first = block * TILE_ITEMS + me * TILE_ITEMS_EACH;
    uint mine = 0u;
    for (uint i = 0u; i < TILE_ITEMS_EACH; ++i)
        if (first + i < push.count) mine += data[first + i];
    uint sum = scan_tile(mine);
    for (uint i = 0u; i < TILE_ITEMS_EACH; ++i) {
        if (first + i >= push.count) break;
        const uint value = data[first + i];
        data[first + i] = sum;
        sum += value;
    }
    if (me == TILE_GROUP - 1u && block * TILE_ITEMS < push.count) block_sums[block] = sum;
}

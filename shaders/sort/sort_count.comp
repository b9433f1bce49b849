// sort: counts how often each digit occurs in each tile.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "sort/radix_tile.glsl"

layout(std430, binding = BINDING_SCAN_DATA) writeonly buffer Counts { uint counts[]; };

shared uint totals[DIGITS];

void main() {
    const uint tile = linear_group();
    const uint me = gl_LocalInvocationID.x;
    const uint size = size_of_tile(tile);
    for (uint digit = me; digit < DIGITS; digit += TILE_GROUP) totals[digit] = 0u;
    barrier();
    for (uint item = me; item < size; item += TILE_GROUP)
        atomicAdd(totals[digit_of(keys_in[tile * TILE_ITEMS + item])], 1u);
    barrier();
    for (uint digit = me; digit < DIGITS && size > 0u; digit += TILE_GROUP)
        counts[digit * push.tiles + tile] = totals[digit];
}

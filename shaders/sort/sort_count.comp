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
    if (me < DIGITS) totals[me] = 0u;
    barrier();
    if (tile < push.tiles) {
        const uvec2 mine = count_digits(tile * TILE_ITEMS + me * TILE_ITEMS_EACH);
        for (uint digit = 0u; digit < DIGITS; ++digit) {
            const uint n = count_of(mine, digit);
            if (n > 0u) atomicAdd(totals[digit], n);
        }
    }
    barrier();
    if (tile < push.tiles && me < DIGITS) counts[me * push.tiles + tile] = totals[me];
}

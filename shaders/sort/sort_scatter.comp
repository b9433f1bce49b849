// sort: moves each item to its place; items of equal digit keep their order.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "sort/radix_tile.glsl"

layout(std430, binding = BINDING_INDEX_IN) readonly buffer IndexIn { uint index_in[]; };
layout(std430, binding = BINDING_KEYS_OUT) writeonly buffer KeysOut { uvec2 keys_out[]; };
layout(std430, binding = BINDING_INDEX_OUT) writeonly buffer IndexOut { uint index_out[]; };
layout(std430, binding = BINDING_SCAN_DATA) readonly buffer Offsets { uint offsets[]; };

// Counts of items with digit 2w (low half) and 2w + 1 (high half), up to and including an invocation's own.
shared uint sums[DIGITS / 2][TILE_GROUP];

void main() {
    const uint tile = linear_group();
    const uint me = gl_LocalInvocationID.x;
    const uint first = tile * TILE_ITEMS + me * TILE_ITEMS_EACH;
    const uvec2 mine = tile < push.tiles ? count_digits(first) : uvec2(0);
    for (uint w = 0u; w < DIGITS / 2; ++w)
        sums[w][me] = count_of(mine, 2u * w) | (count_of(mine, 2u * w + 1u) << 16);
    barrier();
    for (uint step = 1u; step < TILE_GROUP; step <<= 1) {
        uint before[DIGITS / 2];
        for (uint w = 0u; w < DIGITS / 2; ++w) before[w] = me >= step ? sums[w][me - step] : 0u;
        barrier();
        for (uint w = 0u; w < DIGITS / 2; ++w) sums[w][me] += before[w];
        barrier();
    }
    if (tile >= push.tiles) return;

    uvec2 seen = uvec2(0);
    for (uint i = 0u; i < TILE_ITEMS_EACH; ++i) {
        if (first + i >= push.count) break;
        const uvec2 key = keys_in[first + i];
        const uint digit = digit_of(key);
        const uint up_to_mine = (sums[digit >> 1][me] >> (16u * (digit & 1u))) & 0xffffu;
        const uint place = offsets[digit * push.tiles + tile] + up_to_mine - count_of(mine, digit) + count_of(seen, digit);
        seen[digit >> 3] += 1u << (4u * (digit & 7u));
        keys_out[place] = key;
        index_out[place] = index_in[first + i];
    }
}

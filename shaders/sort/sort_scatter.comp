// sort: moves each item to its place; items of equal digit keep their order.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "sort/radix_tile.glsl"
#include "sort/scan_tile.glsl"

layout(std430, binding = BINDING_INDEX_IN) readonly buffer IndexIn { uint index_in[]; };
layout(std430, binding = BINDING_KEYS_OUT) writeonly buffer KeysOut { uvec2 keys_out[]; };
layout(std430, binding = BINDING_INDEX_OUT) writeonly buffer IndexOut { uint index_out[]; };
layout(std430, binding = BINDING_SCAN_DATA) readonly buffer Offsets { uint offsets[]; };
// Offsets count from the begin of a block of TILE_ITEMS, and blocks from here, except the first.
layout(std430, binding = BINDING_SCAN_SUMS) readonly buffer Sums { uint block_sums[]; };

const uint half_bits = DIGIT_BITS / 2, half_mask = (1u << half_bits) - 1u;
const uint rows = (half_mask + 1u) / 2u;  // of counts, with two halves of digits each: d and d + rows

shared uint order[TILE_ITEMS];            // items of the tile with their digits in the low bits
shared uint counts[rows * TILE_GROUP];    // by half digit and invocation
shared uint begins[DIGITS];               // of each digit in the order

// Four bits for each half digit. An invocation has fewer than 16 items.
struct HalfCounts {
    uvec2 bits;
};

uint count_of(HalfCounts n, uint d) {
    return (n.bits[d / rows] >> (4u * (d % rows))) & 15u;
}

void add(inout HalfCounts n, uint d) {
    n.bits[d / rows] += 1u << (4u * (d % rows));
}

// Sorts the order by one half of the digits; equal ones keep their order.
void sort_by(uint shift) {
    const uint me = gl_LocalInvocationID.x, first = me * TILE_ITEMS_EACH;
    uint items[TILE_ITEMS_EACH];
    HalfCounts mine = HalfCounts(uvec2(0)), seen = mine;
    for (uint i = 0u; i < TILE_ITEMS_EACH; ++i) {
        items[i] = order[first + i];
        add(mine, (items[i] >> shift) & half_mask);
    }
    for (uint d = 0u; d < rows; ++d)
        counts[d * TILE_GROUP + me] = count_of(mine, d) | (count_of(mine, d + rows) << 16);
    barrier();
    uint sum = 0u;
    for (uint i = 0u; i < rows; ++i) sum += counts[me * rows + i];
    sum = scan_tile(sum);
    for (uint i = 0u; i < rows; ++i) {
        const uint n = counts[me * rows + i];
        counts[me * rows + i] = sum;
        sum += n;
    }
    barrier();
    const uint low = sums_of_tile[TILE_GROUP - 1u] & 0xffffu;  // items with a half digit below `rows`
    for (uint i = 0u; i < TILE_ITEMS_EACH; ++i) {
        const uint d = (items[i] >> shift) & half_mask, before = counts[d % rows * TILE_GROUP + me];
        order[(d < rows ? before & 0xffffu : low + (before >> 16)) + count_of(seen, d)] = items[i];
        add(seen, d);
    }
    barrier();
}

void main() {
    const uint tile = linear_group(), first = tile * TILE_ITEMS;
    const uint me = gl_LocalInvocationID.x;
    const uint size = size_of_tile(tile);
    // Places without an item have the last digit, and stay behind the items.
    for (uint item = me; item < TILE_ITEMS; item += TILE_GROUP)
        order[item] = item << DIGIT_BITS | (item < size ? digit_of(keys_in[first + item]) : DIGITS - 1u);
    barrier();
    sort_by(0u);
    sort_by(half_bits);
    for (uint place = me; place < size; place += TILE_GROUP) {
        const uint digit = order[place] & (DIGITS - 1u);
        if (place == 0u || (order[place - 1u] & (DIGITS - 1u)) != digit) begins[digit] = place;
    }
    barrier();
    for (uint place = me; place < size; place += TILE_GROUP) {
        const uint digit = order[place] & (DIGITS - 1u), item = first + (order[place] >> DIGIT_BITS);
        const uint count = digit * push.tiles + tile, block = count / TILE_ITEMS;
        const uint to = offsets[count] + (block > 0u ? block_sums[block] : 0u) + place - begins[digit];
        keys_out[to] = keys_in[item];
        index_out[to] = index_in[item];
    }
}

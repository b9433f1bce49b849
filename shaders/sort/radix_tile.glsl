// A tile of the radix sort: TILE_ITEMS consecutive items, TILE_ITEMS_EACH consecutive ones per invocation.
#ifndef VOTESS_SORT_RADIX_TILE_GLSL
#define VOTESS_SORT_RADIX_TILE_GLSL

#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { SortPush push; };
layout(std430, binding = BINDING_KEYS_IN) readonly buffer KeysIn { uvec2 keys_in[]; };

// Returns the digit of an item.
uint digit_of(uvec2 key) {
    return ((push.high_word != 0u ? key.y : key.x) >> push.shift) & (DIGITS - 1u);
}

// Returns how often each digit occurs among an invocation's items, four bits a digit.
uvec2 count_digits(uint first) {
    uvec2 counts = uvec2(0);
    for (uint i = 0u; i < TILE_ITEMS_EACH; ++i) {
        if (first + i >= push.count) break;
        const uint digit = digit_of(keys_in[first + i]);
        counts[digit >> 3] += 1u << (4u * (digit & 7u));
    }
    return counts;
}

uint count_of(uvec2 counts, uint digit) {
    return (counts[digit >> 3] >> (4u * (digit & 7u))) & 15u;
}

#endif

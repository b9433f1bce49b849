// A tile of the radix sort: TILE_ITEMS consecutive items.
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

// Returns the number of items of a tile; 0 beyond the last tile.
uint size_of_tile(uint tile) {
    return tile < push.tiles ? min(push.count - tile * TILE_ITEMS, TILE_ITEMS) : 0u;
}

#endif

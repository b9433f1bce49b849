// The numbers of nodes of the hierarchy's levels, from the number of seeds. The .comp declares `push`, with seed_count,
// before.
#ifndef VOTESS_SEARCH_LEVELS_GLSL
#define VOTESS_SEARCH_LEVELS_GLSL

#include "shared/config.h"

uint nodes_of(uint level) {
    return ((push.seed_count - 1u) >> (FAN_BITS * (level + 1u))) + 1u;
}

// Returns the sum of nodes_of() over the levels below: `level` ones, and floor(m / 8^i) for i = 1 .. level. By
// Legendre's formula these are (m - floor(m / 8^level) - the sum of the last digits of m to base 8) / 7.
uint nodes_below(uint level) {
    const uint m = push.seed_count - 1u, digits = m & ((1u << (FAN_BITS * level)) - 1u);
    const uint digit_sum = uint(bitCount(digits & 011111111111u)) + 2u * uint(bitCount(digits & 022222222222u)) +
                           4u * uint(bitCount(digits & 04444444444u));
    return level + (m - (m >> (FAN_BITS * level)) - digit_sum) * 0xb6db6db7u;  // 1 / 7 modulo 2^32
}

#endif

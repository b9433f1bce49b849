// Whole numbers of 128 bits, modulo 2^128: four words in two's complement, low words first.
#ifndef VOTESS_NUMBERS_INT128_GLSL
#define VOTESS_NUMBERS_INT128_GLSL

#include "numbers/int64.glsl"

uvec4 add128(uvec4 a, uvec4 b) {
    uvec4 sum, carry, more;
    sum = uaddCarry(a, b, carry);
    sum.y = uaddCarry(sum.y, carry.x, more.y);
    sum.z = uaddCarry(sum.z, carry.y + more.y, more.z);
    sum.w += carry.z + more.z;
    return sum;
}

uvec4 negate128(uvec4 a) {
    return add128(~a, uvec4(1u, 0u, 0u, 0u));
}

// n < 96
uvec4 shift_left128(uvec4 a, uint n) {
    if (n >= 64u) a = uvec4(0u, 0u, a.xy);
    if ((n & 32u) != 0u) a = uvec4(0u, a.xyz);
    const uint bits = n & 31u;
    return bits == 0u ? a : (a << bits) | (uvec4(0u, a.xyz) >> (32u - bits));
}

// Returns a number of 64 bits in two's complement.
uvec4 extend128(uvec2 a) {
    return uvec4(a, uvec2(uint(int(a.y) >> 31)));
}

// Returns a b of numbers in two's complement.
uvec4 product128(uvec2 a, int b) {
    const uvec2 m = magnitude64(a);
    uvec2 low, high;
    umulExtended(m, uvec2(uint(abs(b))), high, low);
    uint carry;
    const uint middle = uaddCarry(low.y, high.x, carry);
    const uvec4 product = uvec4(low.x, middle, high.y + carry, 0u);
    return is_negative(a) != (b < 0) ? negate128(product) : product;
}

// Returns a b of unsigned numbers.
uvec4 product128(uvec2 a, uvec2 b) {
    uvec4 low, high;
    umulExtended(uvec4(a.x, a.x, a.y, a.y), uvec4(b.x, b.y, b.x, b.y), high, low);
    return add128(uvec4(low.x, high.x, low.w, high.w),
                  add128(uvec4(0u, low.y, high.y, 0u), uvec4(0u, low.z, high.z, 0u)));
}

#endif

// Whole numbers of 128 bits, modulo 2^128: four words in two's complement, low words first.
#ifndef VOTESS_NUMBERS_INT128_GLSL
#define VOTESS_NUMBERS_INT128_GLSL

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

// Returns a b of unsigned numbers.
uvec4 product128(uvec2 a, uvec2 b) {
    uvec4 low, high;
    umulExtended(uvec4(a.x, a.x, a.y, a.y), uvec4(b.x, b.y, b.x, b.y), high, low);
    return add128(uvec4(low.x, high.x, low.w, high.w),
                  add128(uvec4(0u, low.y, high.y, 0u), uvec4(0u, low.z, high.z, 0u)));
}

#endif

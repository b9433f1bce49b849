// Whole numbers of 64 bits, modulo 2^64, as two words (x low, y high): not every device has them.
#ifndef VOTESS_NUMBERS_INT64_GLSL
#define VOTESS_NUMBERS_INT64_GLSL

uvec2 add64(uvec2 a, uvec2 b) {
    uint carry;
    const uint low = uaddCarry(a.x, b.x, carry);
    return uvec2(low, a.y + b.y + carry);
}

uvec2 subtract64(uvec2 a, uvec2 b) {
    uint borrow;
    const uint low = usubBorrow(a.x, b.x, borrow);
    return uvec2(low, a.y - b.y - borrow);
}

uvec2 negate64(uvec2 a) {
    return subtract64(uvec2(0), a);
}

bool is_negative(uvec2 a) {
    return (a.y & 0x80000000u) != 0u;
}

uvec2 magnitude64(uvec2 a) {
    return is_negative(a) ? negate64(a) : a;
}

// Returns the product of a and a signed number in two's complement.
uvec2 times64(int a, int b) {
    int high, low;
    imulExtended(a, b, high, low);
    return uvec2(uint(low), uint(high));
}
uvec2 times64(int a, uvec2 b) {
    uint high, low;
    umulExtended(uint(a), b.x, high, low);
    return uvec2(low, high + uint(a) * b.y - (a < 0 ? b.x : 0u));
}

bool less64(uvec2 a, uvec2 b) {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

uvec2 min64(uvec2 a, uvec2 b) {
    return less64(a, b) ? a : b;
}

uvec2 max64(uvec2 a, uvec2 b) {
    return less64(a, b) ? b : a;
}

// n >= 0; the result is zero from n = 64 on.
uvec2 shift_left64(uvec2 a, uint n) {
    if (n >= 64u) return uvec2(0);
    if (n >= 32u) return uvec2(0u, a.x << (n - 32u));
    if (n == 0u) return a;
    return uvec2(a.x << n, (a.y << n) | (a.x >> (32u - n)));
}

// Shifts a number in two's complement right, rounding down. Sets `lost` when bits are lost.
uvec2 shift_right64(uvec2 a, uint n, inout bool lost) {
    const uint sign = (a.y & 0x80000000u) != 0u ? 0xffffffffu : 0u;
    if (n == 0u) return a;
    if (n >= 64u) {
        lost = lost || (a.x | a.y) != 0u;
        return uvec2(sign);
    }
    if (n >= 32u) {
        const uint m = n - 32u;
        lost = lost || a.x != 0u || (m > 0u && (a.y << (32u - m)) != 0u);
        return uvec2(m == 0u ? a.y : ((a.y >> m) | (sign << (32u - m))), sign);
    }
    lost = lost || (a.x << (32u - n)) != 0u;
    return uvec2((a.x >> n) | (a.y << (32u - n)), (a.y >> n) | (sign << (32u - n)));
}

// Returns q - p in two's complement, right to three roundings. Searches call it often, so it has no branches. The low word
// counts as signed, so that a small negative number does not cancel.
float rough_difference(uvec2 q, uvec2 p) {
    const uvec2 d = subtract64(q, p);
    return float(int(d.y + (d.x >> 31))) * 4294967296.0 + float(int(d.x));
}

// Returns a number below 2^64 with one rounding: its leading 32 bits, the last one set when any lower bit is.
float round64(uvec2 m) {
    const bool small = m.y == 0u;
    const uint shift = uint(31 - findMSB(m.y | 1u));  // left shift of the high word, 0 .. 31
    const uint leading = (m.y << shift) | ((m.x >> 1) >> (31u - shift)), rest = m.x << shift;
    const uint kept = leading | min(rest, 1u);
    const float high = float(kept) * uintBitsToFloat((159u - shift) << 23);
    return mix(high, float(m.x), small);
}

#endif

// The bits of the double that equals a float.
#ifndef VOTESS_NUMBERS_WIDENED_GLSL
#define VOTESS_NUMBERS_WIDENED_GLSL

// bits: of a finite float.
uvec2 widened(uint bits) {
    uint exponent = (bits >> 23) & 0xffu, mantissa = bits & 0x7fffffu;
    const uint sign = bits & 0x80000000u;
    if (exponent == 0u) {
        if (mantissa == 0u) return uvec2(0u, sign);
        const uint up = 23u - uint(findMSB(mantissa));
        mantissa = (mantissa << up) & 0x7fffffu;
        return uvec2(mantissa << 29, sign | ((897u - up) << 20) | (mantissa >> 3));
    }
    return uvec2(mantissa << 29, sign | ((exponent + 896u) << 20) | (mantissa >> 3));
}

#endif

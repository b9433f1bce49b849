// Coordinates relative to a cell's seed, in units of the cell.
#ifndef VOTESS_CLIP_RELATIVE_TO_SEED_GLSL
#define VOTESS_CLIP_RELATIVE_TO_SEED_GLSL

#include "numbers/int64.glsl"
#include "numbers/real.glsl"

uvec2 px, py, pz;    // the seed
float scale;         // 2^-k: units to units of the cell
uvec2 pw;            // in a power diagram, the seed's weight
float weight_scale;  // units of weight to squared units of the cell

// Returns q - p in units of the cell, right to two units of coordinates and one rounding; in float64 to one rounding.
real difference(uvec2 q, uvec2 p) {
    const uvec2 d = subtract64(q, p);
#ifdef CLIP_FLOAT64
    const uvec2 m = magnitude64(d);
    const real magnitude = (real(m.y) * 4294967296.0LF + real(m.x)) * real(scale);
    return is_negative(d) ? -magnitude : magnitude;
#else
    const uint sign = uint(int(d.y) >> 31);  // all ones when negative
    const uvec2 m = d ^ sign;                // of a negative number less by one
    // The leading 32 bits, with the power of two that they lack in the exponent.
    const uint shift = uint(31 - findMSB(m.y | 1u)), leading = (m.y << shift) | ((m.x >> 1) >> (31u - shift));
    const float magnitude = float(leading) * uintBitsToFloat(floatBitsToUint(scale) + ((32u - shift) << 23));
    return uintBitsToFloat(floatBitsToUint(magnitude) | (sign & 0x80000000u));
#endif
}

// Returns how much lighter a seed of weight w is than the cell's, in squared units of the cell, with one rounding.
real lighter_by(uvec2 w) {
    const uvec2 d = subtract64(pw, w), m = magnitude64(d);
#ifdef CLIP_FLOAT64
    const real magnitude = (real(m.y) * 4294967296.0LF + real(m.x)) * real(weight_scale);
#else
    const real magnitude = round64(m) * weight_scale;
#endif
    return is_negative(d) ? -magnitude : magnitude;
}

#endif

// Coordinates relative to a cell's seed, in units of the cell.
#ifndef VOTESS_CLIP_RELATIVE_TO_SEED_GLSL
#define VOTESS_CLIP_RELATIVE_TO_SEED_GLSL

#include "numbers/int64.glsl"
#include "numbers/real.glsl"

uvec2 px, py, pz;    // the seed
float scale;         // 2^-k: units to units of the cell
uvec2 pw;            // in a power diagram, the seed's weight
float weight_scale;  // units of weight to squared units of the cell

// q - p, times a power of two, with one rounding.
real difference(uvec2 q, uvec2 p, float power_of_two) {
    const uvec2 d = subtract64(q, p);
    const bool negative = (d.y & 0x80000000u) != 0u;
    const uvec2 m = negative ? negate64(d) : d;
#ifdef CLIP_FLOAT64
    const real magnitude = (real(m.y) * 4294967296.0LF + real(m.x)) * real(power_of_two);
#else
    const real magnitude = round64(m) * power_of_two;
#endif
    return negative ? -magnitude : magnitude;
}

// In units of the cell.
real difference(uvec2 q, uvec2 p) {
    return difference(q, p, scale);
}

// How much lighter than the cell's seed one of weight w is, in squared units of the cell with one rounding.
real lighter_by(uvec2 w) {
    return difference(pw, w, weight_scale);
}

#endif

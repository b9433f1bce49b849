// Coordinates relative to a cell's seed, in units of the cell.
#ifndef VOTESS_CLIP_RELATIVE_TO_SEED_GLSL
#define VOTESS_CLIP_RELATIVE_TO_SEED_GLSL

#include "numbers/int64.glsl"
#include "numbers/real.glsl"

uvec2 px, py, pz;  // the seed
float scale;       // 2^-k: units to units of the cell

// q - p in units of the cell with one rounding.
real difference(uvec2 q, uvec2 p) {
    const uvec2 d = subtract64(q, p);
    const bool negative = (d.y & 0x80000000u) != 0u;
    const uvec2 m = negative ? negate64(d) : d;
#ifdef CLIP_FLOAT64
    const real magnitude = (real(m.y) * 4294967296.0LF + real(m.x)) * real(scale);
#else
    const real magnitude = round64(m) * scale;
#endif
    return negative ? -magnitude : magnitude;
}

#endif

// Coordinates relative to a cell's seed p, in units of the cell.
//
// In a power diagram the planes and vertices of the cell are relative to its center p - a. The tilt a is half of the
// gradient of the weights around the seed. A plane n.x = h relative to the seed is n.X = h + n.a relative to the center.
// The bisector with a seed at n that is lighter by w has h + n.a = (|n|^2 + w + 2 a.n) / 2. So it looks like that of a
// seed that is lighter by w + 2 a.n, by what the tilt leaves of the weights. That sum is computed in whole numbers,
// because it cancels.
#ifndef VOTESS_CLIP_RELATIVE_TO_SEED_GLSL
#define VOTESS_CLIP_RELATIVE_TO_SEED_GLSL

#include "numbers/int128.glsl"
#include "numbers/int64.glsl"
#include "numbers/real.glsl"
#include "shared/config.h"

uvec2 px, py, pz;    // the seed
uvec2 cx, cy, cz;    // the center, in two's complement
float scale;         // 2^-k: units to units of the cell
uvec2 pw;            // in a power diagram, the seed's weight
ivec3 tilt;          // a, in 2^TILT_BITS units
bool is_tilted;      // a is not 0
uint weight_bits;    // a unit of weight is 2^weight_bits squared units
float weight_scale;  // units of weight to squared units of the cell

// Returns a component of a tilt in units, in two's complement.
uvec2 tilt_units(int a) {
    return shift_left64(uvec2(uint(a), uint(a >> 31)), TILT_BITS);
}

// Sets the center. tilt_in_units: of the node of the seed's group; without weights, 0.
void set_center(vec3 tilt_in_units) {
    tilt = ivec3(tilt_in_units * exp2(-float(TILT_BITS)));
    is_tilted = any(notEqual(tilt, ivec3(0)));
    cx = subtract64(px, tilt_units(tilt.x));
    cy = subtract64(py, tilt_units(tilt.y));
    cz = subtract64(pz, tilt_units(tilt.z));
}

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

// Returns how much lighter a seed of weight w is than the cell's, plus 2 a.n, in squared units. The sum is below 2^127:
// weights differ by at most 2^126, and a component of a is below 2^59 units (search/knn_boxes.comp).
uvec4 tilted_lighter_by(uvec2 w, uvec2 x, uvec2 y, uvec2 z) {
    const uvec4 along = add128(product128(subtract64(x, px), tilt.x),
                               add128(product128(subtract64(y, py), tilt.y), product128(subtract64(z, pz), tilt.z)));
    return add128(shift_left128(extend128(subtract64(pw, w)), weight_bits), shift_left128(along, TILT_BITS + 1));
}

// Returns a number of 64 bits in units of weight, with one rounding.
real round_weight(uvec2 m) {
#ifdef CLIP_FLOAT64
    return real(m.y) * 4294967296.0LF + real(m.x);
#else
    return round64(m);
#endif
}

// Returns how much lighter a seed of weight w is than the cell's, in squared units of the cell, with one rounding.
real lighter_by(uvec2 w) {
    const uvec2 d = subtract64(pw, w);
    const real magnitude = round_weight(magnitude64(d)) * real(weight_scale);
    return is_negative(d) ? -magnitude : magnitude;
}

// The same for a seed at this place, less the tilt's share.
real lighter_by(uvec2 w, uvec2 x, uvec2 y, uvec2 z) {
    if (!is_tilted) return lighter_by(w);
    const uvec4 d = tilted_lighter_by(w, x, y, z);
    const bool negative = int(d.w) < 0;
    uvec4 m = negative ? negate128(d) : d;
    // The leading 64 bits, the last one set when any lower bit is.
    uint shift = m.w != 0u ? 0u : (m.z != 0u ? 32u : 64u);
    m = shift_left128(m, shift);
    const uint rest = m.w != 0u ? uint(31 - findMSB(m.w)) : 0u;
    m = shift_left128(m, rest);
    shift += rest;
    const real leading = round_weight(uvec2(m.z | min(m.x | m.y, 1u), m.w)) * real(scale) * real(scale);
    const real magnitude = leading * real(uintBitsToFloat((191u - shift) << 23));
    return negative ? -magnitude : magnitude;
}

#endif

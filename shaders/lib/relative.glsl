// Coordinates relative to a cell's seed, in units of the cell.
// Needs lib/int64.glsl, lib/real.glsl and push.extent.

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

geometry_real geometry_difference(uvec2 q, uvec2 p) {
#if defined(GEOMETRY_FLOAT64) && !defined(CLIP_FLOAT64)
    const uvec2 d = subtract64(q, p);
    const bool negative = (d.y & 0x80000000u) != 0u;
    const uvec2 m = negative ? negate64(d) : d;
    const double magnitude = (double(m.y) * 4294967296.0LF + double(m.x)) * double(scale);
    return negative ? -magnitude : magnitude;
#else
    return difference(q, p);
#endif
}

// Distance of the seed to wall i.
geometry_real wall_distance(int i) {
    const uvec2 p = i / 2 == 0 ? px : (i / 2 == 1 ? py : pz);
    return (i & 1) == 0 ? geometry_difference(p, uvec2(0)) : geometry_difference(push.extent[i / 2], p);
}

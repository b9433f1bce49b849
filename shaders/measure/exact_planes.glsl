// The planes of a finished cell in the numbers of measures. The .comp declares `push`, with extent, before.
#ifndef VOTESS_MEASURE_EXACT_PLANES_GLSL
#define VOTESS_MEASURE_EXACT_PLANES_GLSL

#include "clip/cell_results.glsl"
#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "clip/walls.glsl"
#include "numbers/int64.glsl"
#include "numbers/number.glsl"
#include "search/nodes.glsl"
#include "search/seeds.glsl"

// Returns q - p times a power of two, or in units of the cell, in the numbers of measures.
Number exact_number(uvec2 d, float power_of_two) {
    const bool negative = (d.y & 0x80000000u) != 0u;
    const uvec2 m = negative ? negate64(d) : d;
    return times_power(number64(m), negative ? -power_of_two : power_of_two);
}
Number exact_difference(uvec2 q, uvec2 p, float power_of_two) {
    return exact_number(subtract64(q, p), power_of_two);
}
Number exact_difference(uvec2 q, uvec2 p) {
    return exact_difference(q, p, scale);
}

// Returns how much lighter seed q is than the cell's, less the tilt's share, in squared units of the cell.
Number exact_lighter_by(uint q) {
    if (!is_tilted) return exact_difference(pw, seed_weight(q), weight_scale);
    const uvec4 d = tilted_lighter_by(seed_weight(q), seed_x(q), seed_y(q), seed_z(q));
    const bool negative = is_negative(d.zw);
    const uvec4 m = negative ? negate128(d) : d;
    const float power = negative ? -scale * scale : scale * scale;
    return plus(times_power(number64(m.zw), power * 18446744073709551616.0), times_power(number64(m.xy), power));
}

// A plane n.x = h = foot |n|^2. The foot of the seed on it is foot n; of bisectors foot is 1/2, with weights
// 1/2 + w / (2 |n|^2). Float64 measures by foot, sums of two float32 by h.
#ifdef GEOMETRY_FLOAT64
struct ExactPlane {
    Vector n;
    Number foot;
};
#else
struct ExactPlane {
    Vector n;
    Number h;
};
#endif

ExactPlane exact_wall(uint i) {
    if (has_walls != 0u && i >= 6u) {
        const WallPlane wall = walls[i - 6u];
        Number n[3];
        for (int k = 0; k < 3; ++k)
            n[k] = times_power(number64(magnitude64(wall.normal[k])),
                               wall_step * (is_negative(wall.normal[k]) ? -1.0 : 1.0));
        const Number h = exact_difference(wall_distance(wall), uvec2(0));
        return ExactPlane(Vector(n[0], n[1], n[2]), h);
    }
    const Number zero = number(0.0), side = number((i & 1u) != 0u ? 1.0 : -1.0);
    const uint axis = i / 2u;
    const uvec2 c = axis == 0u ? cx : (axis == 1u ? cy : cz);
    const bool is_upper = (i & 1u) != 0u;
    const Number h = exact_difference(is_upper ? push.extent[axis] : c, is_upper ? c : uvec2(0));
    return ExactPlane(Vector(axis == 0u ? side : zero, axis == 1u ? side : zero, axis == 2u ? side : zero), h);
}

ExactPlane exact_bisector(uint q) {
    uvec2 x = subtract64(seed_x(q), px), y = subtract64(seed_y(q), py), z = subtract64(seed_z(q), pz);
    Vector n = Vector(number(0.0), number(0.0), number(0.0));
    Number square = number(0.0);
    [[dont_unroll]] for (int k = 0; k < 3; ++k) {
        const Number next = exact_number(x, scale);
        square = plus(square, times(next, next));
        n = Vector(n.y, n.z, next);
        x = y;
        y = z;
    }
#ifdef GEOMETRY_FLOAT64
    if (weighted == 0u) return ExactPlane(n, number(0.5));
    const Number lighter = exact_lighter_by(q);
    return ExactPlane(n, times(number(0.5), plus(number(1.0), times(lighter, reciprocal(square)))));
#else
    if (weighted != 0u) square = plus(square, exact_lighter_by(q));
    return ExactPlane(n, times_power(square, 0.5));
#endif
}

// Return a plane of the measured cell, and the three packed planes of a vertex; defined where they are stored.
ExactPlane exact_plane_at(uint plane);
uint planes_of_vertex(uint vertex);

#endif

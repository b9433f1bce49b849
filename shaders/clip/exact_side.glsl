// Ties: the exact side of a vertex that the filter is not sure of. The coordinates of its planes, relative to the seed,
// must be small whole numbers times a power of two, as in a lattice. A vertex on a plane stays
// (engine/exact/predicate.hpp). It may then coincide with others, and faces may have no area.
//
// A plane is 2 n.X = s, with n = q - p and s = |n|^2 for a bisector, n = +-e and s twice the distance for a wall of the
// box. By Cramer's rule the vertex of a, b, c, with det(a,b,c) > 0 as cells keep them, lies outside of d when
//     s_a det(d,b,c) + s_b det(d,c,a) + s_c det(d,a,b) - s_d det(a,b,c) > 0 .
// With |n| < 2^11 an axis and s < 2^24, cross products are below 2^23, which float32 holds exactly. Determinants are
// below 3 2^34, and the sum is below 2^62.
//
// The .comp declares `push`, with extent, before.
#ifndef VOTESS_CLIP_EXACT_SIDE_GLSL
#define VOTESS_CLIP_EXACT_SIDE_GLSL

#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "numbers/int64.glsl"
#include "search/seeds.glsl"

const int side_unknown = 2;
const float max_offset = 2048.0, max_square = 16777216.0;

// The bits of the plane's numbers, without trailing bits that are zero in all.
uvec2 bits_of_plane(int id) {
    if (id >= 0) return subtract64(seed_x(id), px) | subtract64(seed_y(id), py) | subtract64(seed_z(id), pz);
    const uint wall = uint(-1 - id), axis = wall / 2u;
    const uvec2 p = axis == 0u ? px : (axis == 1u ? py : pz);
    const uvec2 distance = (wall & 1u) != 0u ? subtract64(push.extent[axis], p) : p;
    return uvec2(distance.x << 1, (distance.y << 1) | (distance.x >> 31));
}

// Returns n and s, exact when they fit: differences of few bits are not rounded.
vec4 small_plane(int id, float unit, inout bool fits) {
    vec3 n = vec3(0.0);
    float s = 0.0;
    if (id >= 0) {
        n = vec3(rough_difference(seed_x(id), px), rough_difference(seed_y(id), py), rough_difference(seed_z(id), pz)) *
            unit;
        s = dot(n, n);
    } else {
        const uint wall = uint(-1 - id), axis = wall / 2u;
        const uvec2 p = axis == 0u ? px : (axis == 1u ? py : pz);
        const bool upper = (wall & 1u) != 0u;
        n[axis] = upper ? 1.0 : -1.0;
        s = 2.0 * unit * abs(rough_difference(upper ? push.extent[axis] : uvec2(0), p));
    }
    fits = fits && max(max(abs(n.x), abs(n.y)), abs(n.z)) < max_offset && s < max_square;
    return vec4(n, s);
}

// Returns s det, from n and the cross product of the other two.
uvec2 times_determinant(float s, vec3 n, vec3 others) {
    const ivec3 a = ivec3(n), b = ivec3(others);
    return times64(int(s), add64(add64(times64(a.x, b.x), times64(a.y, b.y)), times64(a.z, b.z)));
}

// Returns the side of plane d on which the vertex of planes a, b, c lies, det(na,nb,nc) > 0: 1 outside, -1 inside, 0 on
// it, or side_unknown. Planes are given by their ids.
int exact_side(int a, int b, int c, int d) {
    if (quantum > real(0) || min(min(a, b), min(c, d)) < -6) return side_unknown;
    const uvec2 bits = bits_of_plane(a) | bits_of_plane(b) | bits_of_plane(c) | bits_of_plane(d);
    const uint zeros = uint(bits.x != 0u ? findLSB(bits.x) : 32 + findLSB(bits.y));
    const float unit_of_planes = uintBitsToFloat((127u - zeros) << 23);
    bool fits = true;
    const vec4 pa = small_plane(a, unit_of_planes, fits), pb = small_plane(b, unit_of_planes, fits),
               pc = small_plane(c, unit_of_planes, fits), pd = small_plane(d, unit_of_planes, fits);
    if (!fits) return side_unknown;
    const vec3 bc = cross(pb.xyz, pc.xyz);
    const uvec2 side = subtract64(add64(add64(times_determinant(pa.w, pd.xyz, bc),
                                              times_determinant(pb.w, pd.xyz, cross(pc.xyz, pa.xyz))),
                                        times_determinant(pc.w, pd.xyz, cross(pa.xyz, pb.xyz))),
                                  times_determinant(pd.w, pa.xyz, bc));
    if ((side.x | side.y) == 0u) return 0;
    return int(side.y) < 0 ? -1 : 1;
}

#endif

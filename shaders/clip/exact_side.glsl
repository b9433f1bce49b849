// Ties: the exact side of a vertex that the filter is not sure of, where the coordinates of its planes, relative to the seed,
// are small whole numbers times a power of two, as in a lattice. A vertex that lies on a plane stays
// (engine/exact/predicate.hpp); it may coincide with others then, and faces may have no area.
//
// A plane is 2 n.X = s, with n = q - p and s = |n|^2 for a bisector, n = +-e and s twice the distance for a wall of the box.
// The vertex of a, b, c is v / (2 det), v = s_a n_b x n_c + s_b n_c x n_a + s_c n_a x n_b, and det > 0 as cells keep
// them: it lies outside of d when n_d.v - s_d det > 0. With |n| < 2^11 an axis and s < 2^24 a component of v is below
// 3 2^24 2^23, and everything fits 64 bits with a sign: 3 2^11 2^48.6 + 2^24 2^35.6 < 2^62.
//
// The .comp declares `push`, with extent, before.
#ifndef VOTESS_CLIP_EXACT_SIDE_GLSL
#define VOTESS_CLIP_EXACT_SIDE_GLSL

#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "numbers/int64.glsl"
#include "search/seeds.glsl"

const int side_unknown = 2;
const uint most_offset = 1u << 11, most_square = 1u << 24;

// Twice the distance of a wall of the box.
uvec2 wall_square(uint wall) {
    const uint axis = wall / 2u;
    const uvec2 p = axis == 0u ? px : (axis == 1u ? py : pz);
    return shift_left64((wall & 1u) != 0u ? subtract64(push.extent[axis], p) : p, 1u);
}

// Bits of the numbers that the plane is made of; what is zero in all of them may be left out.
uvec2 bits_of_plane(int id) {
    if (id < 0) return wall_square(uint(-1 - id));
    return subtract64(seeds_x[id], px) | subtract64(seeds_y[id], py) | subtract64(seeds_z[id], pz);
}

// q - p without its last `zeros` bits, which are zero.
int small_difference(uvec2 q, uvec2 p, uint zeros, inout bool fits) {
    bool lost = false;
    const uvec2 d = shift_right64(subtract64(q, p), zeros, lost);
    fits = fits && add64(d, uvec2(most_offset, 0u)).y == 0u && d.x + most_offset < 2u * most_offset;
    return int(d.x);
}

// n and s.
ivec4 small_plane(int id, uint zeros, inout bool fits) {
    if (id >= 0) {
        const ivec3 n = ivec3(small_difference(seeds_x[id], px, zeros, fits), small_difference(seeds_y[id], py, zeros, fits),
                              small_difference(seeds_z[id], pz, zeros, fits));
        return ivec4(n, n.x * n.x + n.y * n.y + n.z * n.z);
    }
    const uint wall = uint(-1 - id);
    bool lost = false;
    const uvec2 square = shift_right64(wall_square(wall), zeros, lost);
    fits = fits && square.y == 0u && square.x < most_square;
    ivec4 plane = ivec4(0, 0, 0, int(square.x));
    plane[wall / 2u] = (wall & 1u) != 0u ? 1 : -1;
    return plane;
}

// A component of v from those of n_b x n_c, n_c x n_a and n_a x n_b.
uvec2 vertex_numerator(ivec3 squares, int bc, int ca, int ab) {
    return add64(add64(times64(squares.x, bc), times64(squares.y, ca)), times64(squares.z, ab));
}

// On which side of plane d the vertex of planes a, b, c lies, det(na,nb,nc) > 0: 1 outside, -1 inside, 0 on it, or
// side_unknown. Planes go by their ids.
int exact_side(int a, int b, int c, int d) {
    if (quantum > real(0) || min(min(a, b), min(c, d)) < -6) return side_unknown;
    const uvec2 bits = bits_of_plane(a) | bits_of_plane(b) | bits_of_plane(c) | bits_of_plane(d);
    const uint zeros = uint(bits.x != 0u ? findLSB(bits.x) : 32 + findLSB(bits.y));
    bool fits = true;
    const ivec4 pa = small_plane(a, zeros, fits), pb = small_plane(b, zeros, fits), pc = small_plane(c, zeros, fits),
                pd = small_plane(d, zeros, fits);
    if (!fits) return side_unknown;
    const ivec3 ab = pa.yzx * pb.zxy - pa.zxy * pb.yzx, bc = pb.yzx * pc.zxy - pb.zxy * pc.yzx,
                ca = pc.yzx * pa.zxy - pc.zxy * pa.yzx;
    const ivec3 squares = ivec3(pa.w, pb.w, pc.w);
    const uvec2 det = add64(add64(times64(pa.x, bc.x), times64(pa.y, bc.y)), times64(pa.z, bc.z));
    uvec2 side = negate64(times64(pd.w, det));
    side = add64(side, times64(pd.x, vertex_numerator(squares, bc.x, ca.x, ab.x)));
    side = add64(side, times64(pd.y, vertex_numerator(squares, bc.y, ca.y, ab.y)));
    side = add64(side, times64(pd.z, vertex_numerator(squares, bc.z, ca.z, ab.z)));
    if ((side.x | side.y) == 0u) return 0;
    return int(side.y) < 0 ? -1 : 1;
}

#endif

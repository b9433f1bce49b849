// Planes and vertices of the cells of both kernels, and what decides on them, relative to the seed and in units of about
// the distance to its nearest neighbor.
//
// A plane (n, h) is n.x = h with |n| >= 0.89, rounded from the exact one: n to a relative u, h = |n|^2 / 2 to
// 5u. With P = |na||nb||nc|, d = h/|n| and condition P / det(na,nb,nc), Cramer's rule gives the vertex X to
//     |x - X| <= u (condition (13.9 (da + db + dc) + 9.3 |x|) + 6 |x|):
// a numerator's terms are right to 12u (5 of h, 4 of a cross product, 3 of the sum), its products of absolute values at
// most 1.155 h_a |nb||nc|; the determinant is right to 8u and |perm| <= 1.16 P (Carlen, Lieb, Loss 2006); a division
// may err by 2.5 units in the last place, 5u. The test of a plane is right to
//     |n| (|x - X| + 6u |x|) + 10 u h :
// 1u of n and 4u of roundings, each of at most |n||x|; 5u of h and 3u of roundings.
//
// A coordinate that was rounded to units, to 1 + 2^-30 of them below it, moves each plane by at most `quantum` (|x| + 1):
// n by less than sqrt(3) (1 + 2^-29) units, h by that times |n|, over |n|. A wall of any direction is a plane with |n| = 1; rounding moves its h only, by at most
// `quantum`, and h is right to 5u besides. The vertex moves by at most 3 condition times as much, to first order.
//
// Both bounds are of first order in u condition and in quantum condition. With these at most 5e-4 and 1e-3 what is left
// out is less than 1 + 9.3 5e-4 + 3 1e-3 < 1.01 times as much, for which there are factors of 1.05 and of 4 for 3; and
// the determinant has the right sign. A test inside its bound makes the cell uncertain: nothing is decided by rounding.
#ifndef VOTESS_CLIP_FILTER_GLSL
#define VOTESS_CLIP_FILTER_GLSL

#include "numbers/real.glsl"
#include "shared/config.h"

real quantum;

// In units: what coordinates and walls that were rounded move a plane by (clip/walls.glsl). Rounded vectors of a lattice
// put an image half a unit beside its place for each step, that is at most MOST_STEPS_APART / 2, times sqrt(3).
float quantum_in_units(uint lossy) {
    if ((lossy & LOSSY_IMAGES) != 0u) return float(MOST_STEPS_APART);
    return lossy == 0u ? 0.0 : ((lossy & LOSSY_WALLS) != 0u ? 4.0 : 2.0);
}

struct Plane {
    real x, y, z, h, norm;
    real distance;  // h / norm
};

struct Vertex {
    real x, y, z;
    real error;  // |x - X| + 6u |x|
};

// Cells keep the three planes of a vertex, of 8 bits each, in positive orientation: det(na,nb,nc) > 0.
uint pack_planes(uint a, uint b, uint c) {
    return a | (b << 8) | (c << 16);
}
uint plane_of(uint packed, int k) {
    return (packed >> (8 * k)) & 0xffu;
}

// The bisector with a seed at (x, y, z).
Plane bisector(real x, real y, real z) {
    precise const real square = fma(x, x, fma(y, y, z * z));
    const real norm = sqrt(square);
    return Plane(x, y, z, real(0.5) * square, norm, real(0.5) * norm);
}

// Whether the seed is equal in units, or nearer than the neighbor that the cell's unit of length was taken from.
bool is_too_near(Plane p) {
    return !(p.h > real(0.4));
}

// It is positive outside. A fused fma only leaves roundings out.
real side_of(Plane p, real x, real y, real z) {
    precise const real side = fma(p.x, x, fma(p.y, y, fma(p.z, z, -p.h)));
    return side;
}

// A bound of the error of side_of() for a vertex with this error; with the largest error, for all vertices.
real side_bound(Plane p, real error) {
    precise const real bound = fma(p.norm, error, real(10.5) * unit * p.h);
    return bound;
}

// At least the squared security radius: a seed cuts a vertex X off when it is nearer to it than the cell's own, which
// is within 2|X| <= 2 (|x| + error) of that one. The rest is more than the roundings of a square, a root and a product.
real security_radius_squared(real radius_squared, real largest_error) {
    const real radius = real(2.00002) * (sqrt(radius_squared) + largest_error);
    return radius * radius;
}

// Whether no seed at this squared distance, right to 1e-5, or beyond can cut the cell.
bool is_secure(real squared_distance, real security) {
    return squared_distance * real(0.99999) >= security;
}

// At least the radius of the ball around the vertex as computed that holds all places of seeds that cut it off: |X|,
// and |x - X| once more for the center. The rest is more than the roundings of what it is compared with, some 3u of the
// radius an axis, and of coordinates that were rounded to units, for which 2 error has 4 quantum to spare.
real reach_of_vertex(real x, real y, real z, real error) {
    return (sqrt(fma(x, x, fma(y, y, z * z))) + real(2) * error) * real(1.00001);
}

// Whether a box, its bounds relative to the seed, reaches into that ball.
bool is_in_reach(real x, real y, real z, real error, real lower_x, real upper_x, real lower_y, real upper_y,
                 real lower_z, real upper_z) {
    const real dx = max(max(lower_x - x, x - upper_x), real(0)), dy = max(max(lower_y - y, y - upper_y), real(0)),
               dz = max(max(lower_z - z, z - upper_z), real(0));
    const real radius = reach_of_vertex(x, y, z, error);
    return dx * dx + dy * dy + dz * dz <= radius * radius;
}

// Adds how far that ball reaches along the axes, down and up from the seed. Float32 does for it: what a difference of
// such lengths loses is 2e-7 of the radius, of which 1e-5 are to spare.
void extend_reach(vec3 at, float error, inout vec3 down, inout vec3 up) {
    const vec3 radius = vec3((length(at) + 2.0 * error) * 1.00001);
    down = max(down, radius - at);
    up = max(up, radius + at);
}

// x y - z w
real difference_of_products(real x, real y, real z, real w) {
    precise const real second = z * w;
    precise const real result = fma(x, y, -second);
    return result;
}

// The vertex of three planes in positive orientation, det(na,nb,nc) > 0; false when that, or the bound above, is not
// certain.
bool find_vertex(Plane a, Plane b, Plane c, out Vertex vertex) {
    const real bcx = difference_of_products(b.y, c.z, b.z, c.y), bcy = difference_of_products(b.z, c.x, b.x, c.z),
               bcz = difference_of_products(b.x, c.y, b.y, c.x);
    const real cax = difference_of_products(c.y, a.z, c.z, a.y), cay = difference_of_products(c.z, a.x, c.x, a.z),
               caz = difference_of_products(c.x, a.y, c.y, a.x);
    const real abx = difference_of_products(a.y, b.z, a.z, b.y), aby = difference_of_products(a.z, b.x, a.x, b.z),
               abz = difference_of_products(a.x, b.y, a.y, b.x);
    precise const real det = fma(a.x, bcx, fma(a.y, bcy, a.z * bcz));
    precise const real product = a.norm * b.norm * c.norm;
    precise const real inverse = real(1) / det;
    precise const real x = fma(a.h, bcx, fma(b.h, cax, c.h * abx)) * inverse;
    precise const real y = fma(a.h, bcy, fma(b.h, cay, c.h * aby)) * inverse;
    precise const real z = fma(a.h, bcz, fma(b.h, caz, c.h * abz)) * inverse;
    precise const real length = sqrt(fma(x, x, fma(y, y, z * z)));
    precise const real condition = product * inverse;
    precise const real distances = a.distance + b.distance + c.distance;
    precise const real rounding =
        unit * fma(condition, fma(real(13.9), distances, real(9.3) * length), real(12) * length) * real(1.05);
    vertex = Vertex(x, y, z, fma(quantum, fma(real(4), condition, real(1)) * (length + real(1)), rounding));
    return det * real(0.0005) > product * max(unit, real(0.5) * quantum);
}

#endif

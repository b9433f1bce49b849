// The filter of both kernels: planes and vertices of a cell, and the tests that decide on them.
// Everything is relative to the cell's seed, in a power diagram to its center (clip/relative_to_seed.glsl), in units of
// about the distance to the nearest neighbor.
// Each plane and vertex has a bound of its error. A test inside its bound is unknown: the cell becomes uncertain, and
// rounding decides nothing.
// A cell is complete when no seed beyond its security radius can cut it. The bounds follow; u is the unit roundoff.
//
// A plane (n, h) is n.x = h with |n| >= 0.89, rounded from the exact one: n to a relative 1.01 u, h = |n|^2 / 2 to 5u.
// In a power diagram h = (|n|^2 + w) / 2, where the seed is lighter by w than the cell's, less the tilt's share. Then h may
// be small or negative, and is right to 6u of H = (|n|^2 + |w|) / 2: w has one rounding. Without weights H is h. With P = |na||nb||nc|, d = H/|n| and
// condition P / det(na,nb,nc), Cramer's rule gives the vertex X to
//     |x - X| <= u (condition (14 (da + db + dc) + 9.3 |x|) + 6 |x|).
// The terms of a numerator are right to 12u: 5 of h, 2 of the normals, 5 of roundings. Its products of absolute values
// are at most 1.155 H_a |nb||nc|. The determinant is right to 8u, and |perm| <= 1.16 P (Carlen, Lieb, Loss 2006). A
// division errs by at most 2.5 units in the last place, 5u. With 6u of h the terms are right to 13u; the bound allows
// 15.1. The test of a plane is right to
//     |n| (|x - X| + 6u |x|) + 10 u H :
// 1u of n and 4u of roundings, each of at most |n||x|; 6u of H and 3u of roundings.
//
// A coordinate that was rounded down to units, by at most 1 + 2^-30 of them, moves each plane by at most
// `quantum` (|x| + 1). It moves n by less than sqrt(3) (1 + 2^-29) units, and h by that times |n|, which is divided by |n|.
// A wall of any direction is a plane with |n| = 1. Rounding moves only its h, by at most `quantum`, and h is right to 5u
// besides. A weight that was rounded moves h by less than half a unit of weight, and the plane by 0.57 of one; `quantum`
// has 0.6 of it, in addition to the share of coordinates and walls. A tilt a adds n.a to h. Where n moves by less than
// sqrt(3) units, the plane moves by sqrt(3) |a| / |n| of these more, where |n| >= 0.89. So `quantum` is larger by the
// factor 1 + |a|. The H of a wall is h or more, so the bounds hold in a
// power diagram within walls too. The vertex moves by at most 3 condition times as much, to first order.
//
// Both bounds are of first order in u condition and in quantum condition. These are at most 5e-4 and 1e-3, so that higher
// orders add a factor of less than 1 + 9.3 5e-4 + 3 1e-3 < 1.01. The code has factors of 1.05, and 4 instead of 3. The
// determinant also has the right sign then.
//
// A seed cuts a vertex X off when |n - X|^2 + w < |X|^2, that is, when |n|^2 + w < 2 n.X. Let R be the largest distance of
// a vertex. Then s = (|n|^2 + w) / |n| is less than 2 R: searches compare s^2, the key of a seed (search/power.glsl).
// Where w >= -A, such a seed is nearer than R + sqrt(R^2 + A); A is called `heavier`.
#ifndef VOTESS_CLIP_FILTER_GLSL
#define VOTESS_CLIP_FILTER_GLSL

#include "numbers/real.glsl"
#include "numbers/weights.glsl"
#include "shared/config.h"

real quantum;
// Set by prepare_bounds(): factors in the bound of a vertex, of |x|, of the condition and of both, and the largest
// condition.
real error_of_length, error_of_condition, error_of_both, max_condition;
// In a power diagram, in squared units of the cell:
real weight_quantum;  // 0 unless a weight was rounded
real max_heavier;     // A over all seeds, without a tilt
real tilt_length;     // |a|

// Returns how far rounded coordinates and walls move a plane, in units (clip/wall_distance.glsl). Rounded vectors of a
// lattice move an image by half a unit a step: at most MAX_STEPS_APART / 2, times sqrt(3).
float quantum_in_units(uint lossy) {
    if ((lossy & LOSSY_IMAGES) != 0u) return float(MAX_STEPS_APART);
    return lossy == 0u ? 0.0 : ((lossy & LOSSY_WALLS) != 0u ? float(MAX_WALL_ERROR) : 2.0);
}

void prepare_bounds() {
    error_of_length = real(12.6) * unit + quantum;
    error_of_condition = real(4) * quantum;
    error_of_both = (weighted != 0u ? real(9.8) : real(53.9)) * unit + error_of_condition;
    max_condition = real(0.0005) / max(unit, real(0.5) * quantum);
}

struct Plane {
    real x, y, z, h, norm;
    real distance;  // H / norm, in a power diagram
};

struct Vertex {
    real x, y, z;
    real norm;    // |x|
    real error;   // |x - X| + 6u |x|
};

// Packs the three planes of a vertex, 8 bits each, in positive orientation: det(na,nb,nc) > 0.
uint pack_planes(uint a, uint b, uint c) {
    return a | (b << 8) | (c << 16);
}
uint plane_of(uint packed, int k) {
    return (packed >> (8 * k)) & 0xffu;
}

// Returns the bisector with a seed at (x, y, z).
Plane bisector(real x, real y, real z) {
    precise const real square = fma(x, x, fma(y, y, z * z));
    const real norm = sqrt(square);
    return Plane(x, y, z, real(0.5) * square, norm, real(0.5) * norm);
}

// The same for a seed that is lighter by w.
Plane bisector(real x, real y, real z, real w) {
    precise const real square = fma(x, x, fma(y, y, z * z));
    precise const real twice = fma(x, x, fma(y, y, fma(z, z, w)));
    const real norm = sqrt(square);
    return Plane(x, y, z, real(0.5) * twice, norm, real(0.5) * (square + abs(w)) / norm);
}

// Returns H of the bisector with this h and norm: w is the difference of |n|^2 and 2 h.
real size_of(Plane p) {
    return weighted != 0u ? max(p.h, p.norm * p.norm - p.h) : p.h;
}

// Returns H / norm of a plane of the cell; for walls it may be more.
real distance_of(real h, real norm) {
    return weighted != 0u ? max(h / norm, norm - h / norm) : h / norm;
}

// Returns whether the seed is equal in units, or nearer than the neighbor that set the cell's unit of length.
bool is_too_near(Plane p) {
    return weighted != 0u ? !(p.norm > real(0.895)) : !(p.h > real(0.4));
}

// Returns whether a seed that is too near certainly cuts off nothing within the radius. `quantum` bounds the move of n.
bool cannot_cut(Plane p, real radius) {
    return p.h - real(1e-5) * size_of(p) - weight_quantum - p.norm * quantum >
           (p.norm + quantum) * radius * real(1.0001);
}

// Returns a bound of the key that searches find for the bisector's seed; sign: 1 for an upper, -1 for a lower bound. They
// find s right to 5e-5 (|n|^2 + |w_p - w_q| + 2 |a||n|) / |n| + 2.6e-5 |a| + 1e-5 s (search/power.glsl), which is at most
// 1.2e-4 H / |n| + 2.3e-4 |a|.
real key_of(Plane p, real sign) {
    if (weighted == 0u) return real(2) * p.h;
    const real s = (real(2) * p.h + sign * real(1.5e-4) * size_of(p)) / p.norm + sign * real(3e-4) * tilt_length;
    return s * abs(s);
}

// Returns -a. It is a function because NVIDIA's compiler makes an instruction of its own of each precise negation.
real opposite(real a) {
    return -a;
}

// Returns a number that is positive outside. A fused fma has fewer roundings.
real side_of(Plane p, real x, real y, real z) {
    const real minus_h = opposite(p.h);
    precise const real side = fma(p.x, x, fma(p.y, y, fma(p.z, z, minus_h)));
    return side;
}

// Returns a bound of the error of side_of() for a vertex with this error; with the largest error, for all vertices.
real side_bound(Plane p, real error) {
    precise const real bound = fma(p.norm, error, real(10.5) * unit * size_of(p));
    return bound;
}

// Returns an upper bound of how much heavier a seed is than the cell's. lighter: how much lighter it is, rounded.
real heavier_by(real lighter) {
    return real(1e-5) * abs(lighter) - lighter + weight_quantum;
}

// Returns an upper bound of the squared distance of any seed that cuts a cell with vertices within the radius and is
// heavier than the cell's by at most this; 0 when none does. NaN bounds nothing.
real cutting_distance_squared(real radius, real heavier) {
    const real square = radius * radius * real(1.00001) + heavier;
    if (square <= real(0)) return real(0);
    const real distance = radius + sqrt(square);
    return distance * distance * real(1.0001);
}

// Returns an upper bound of the squared security radius. A seed cuts a vertex X off when it is nearer to X than the
// cell's own seed; it is then within 2|X| <= 2 (|x| + error) of that one. The factor exceeds the roundings of a square,
// a root and a product. In a power diagram it is an upper bound of the key of any seed that cuts the cell. Rounding to
// units moves the plane of a seed at most by a quantum where it is nearest to the center; the error has several.
real security_radius_squared(real farthest, real largest_error) {
    const real radius = real(2.00002) * (farthest + largest_error);
    return radius * radius;
}

// Returns whether no seed at this squared distance (in a power diagram, of this key), right to 1e-5, or beyond can cut
// the cell.
bool is_secure(real squared_distance, real security) {
    return squared_distance * real(0.99999) >= security;
}

// Returns an upper bound of the radius of the ball around the computed vertex that holds all seeds that cut it off:
// |X|, plus |x - X| for the center. The factor exceeds the roundings of the compared number, about 1e-6 of the radius an
// axis. For coordinates that were rounded to units, 2 error has 4 quantum to spare.
real reach_of_vertex(real x, real y, real z, real error) {
    return (sqrt(fma(x, x, fma(y, y, z * z))) + real(2) * error) * real(1.00001);
}

// The same for seeds that are heavier by at most this: sqrt(|X|^2 + heavier), or negative where there are none. The
// compared number also errs by 1e-6 of |x|, and moves by less than a quantum; each error has two quantum to spare.
real reach_of_vertex(real x, real y, real z, real error, real heavier) {
    const real length = sqrt(fma(x, x, fma(y, y, z * z))) + error;
    const real square = length * length * real(1.00001) + heavier;
    return square <= real(0) ? real(-1) : (sqrt(square) + error) * real(1.00001) + real(1e-5) * length;
}

// Returns whether a box reaches into that ball. Its bounds are relative to the seed, right to 1e-6.
bool is_in_reach(real x, real y, real z, real error, vec3 lower, vec3 upper, real heavier) {
    const real dx = max(max(real(lower.x) - x, x - real(upper.x)), real(0)),
               dy = max(max(real(lower.y) - y, y - real(upper.y)), real(0)),
               dz = max(max(real(lower.z) - z, z - real(upper.z)), real(0));
    if (weighted != 0u) {
        const real radius = reach_of_vertex(x, y, z, error, heavier);
        return !(radius < real(0)) && !(dx * dx + dy * dy + dz * dz > radius * radius);
    }
    const real radius = reach_of_vertex(x, y, z, error);
    return dx * dx + dy * dy + dz * dz <= radius * radius;
}

// Extends the reach of vertex balls along the axes, down and up from the seed. Float32 suffices: a difference of such
// lengths loses 2e-7 of the radius, which has 1e-5 to spare.
void extend_reach(vec3 at, float error, inout vec3 down, inout vec3 up) {
    const vec3 radius = vec3((length(at) + 2.0 * error) * 1.00001);
    down = max(down, radius - at);
    up = max(up, radius + at);
}

// Returns x y - z w.
real difference_of_products(real x, real y, real z, real w) {
    const real minus_z = opposite(z);
    precise const real second = minus_z * w;
    precise const real result = fma(x, y, second);
    return result;
}

// Returns the bound above for a vertex at this distance from the seed. distances: in a power diagram the sum of those of
// its planes. Else each of these is at most |X|, so that 14 (da + db + dc) + 9.3 |x| is at most 51.3 |X|. The factors are
// 1.05 times those above.
real vertex_error_bound(real condition, real distances, real length) {
    precise real of_condition = fma(error_of_both, length, error_of_condition);
    if (weighted != 0u) of_condition = fma(real(15.9) * unit, distances, of_condition);
    precise const real error = fma(condition, of_condition, fma(error_of_length, length, quantum));
    return error;
}

// Finds the vertex of three planes: (h_a nb x nc + na x (h_c nb - h_b nc)) / det(na,nb,nc). Returns the determinant.
// certain: its sign and the bound above are. Otherwise the determinant may be 0, and the vertex any numbers.
real find_vertex(Plane a, Plane b, Plane c, out Vertex vertex, out bool certain) {
    const real bcx = difference_of_products(b.y, c.z, b.z, c.y), bcy = difference_of_products(b.z, c.x, b.x, c.z),
               bcz = difference_of_products(b.x, c.y, b.y, c.x);
    const real ex = difference_of_products(c.h, b.x, b.h, c.x), ey = difference_of_products(c.h, b.y, b.h, c.y),
               ez = difference_of_products(c.h, b.z, b.h, c.z);
    precise const real det = fma(a.x, bcx, fma(a.y, bcy, a.z * bcz));
    precise const real product = a.norm * b.norm * c.norm;
    certain = abs(det) * max_condition > product;
    precise const real inverse = real(1) / det;
    precise const real x = fma(a.h, bcx, difference_of_products(a.y, ez, a.z, ey)) * inverse;
    precise const real y = fma(a.h, bcy, difference_of_products(a.z, ex, a.x, ez)) * inverse;
    precise const real z = fma(a.h, bcz, difference_of_products(a.x, ey, a.y, ex)) * inverse;
    precise const real length = sqrt(fma(x, x, fma(y, y, z * z)));
    precise const real condition = product * abs(inverse);
    vertex = Vertex(x, y, z, length, vertex_error_bound(condition, a.distance + b.distance + c.distance, length));
    return det;
}

#endif

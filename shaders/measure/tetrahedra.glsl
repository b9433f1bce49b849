// Volume, centroid and areas of the faces of a finished cell in float64, from its planes and vertices. The feet of the seed on a
// face's plane (r_a = foot_a n_a) and on an edge's line (r_ab) split the cell into signed tetrahedra (seed, r_a, r_ab,
// X), two for each edge (a,b) of a vertex X. With t = n_a x n_b and
//     r_ab = alpha n_a + beta n_b,
//     alpha = (h_a |n_b|^2 - h_b n_a.n_b) / |t|^2,  beta = (h_b |n_a|^2 - h_a n_a.n_b) / |t|^2,
// these two together have
//     6 V = (foot_a beta + foot_b alpha) X.t ,
// and add beta X.t / (2 |n_a|) to the area of face a, alpha X.t / (2 |n_b|) to that of b.
//
// With R the farthest vertex, u the unit roundoff: alpha |n_a| <= R / sin(a,b) is right to 41u R / sin^2, X.t to
// |n_a||n_b| (sin |x - X| + 9u R), X to u R (51 condition + 6) as in clip/filter.glsl; so 6 V of an edge is right to
//     u R^3 (100 / sin^2(a,b) + 102 condition + 50) ,
// the last for its sum with all others. The areas together are right to volume_error 3 / R. Relative to the surface
// that is better than the volume, which is at most surface R / 3.
//
// Rounding to units moves the faces by m (moments.glsl). The areas change by 4 m / sin(a,b) times the length of each edge,
// at most 2 R. An edge counts twice in the terms above, so all areas together change by 0.04 m R of those; R / 3 of that
// must also be less than the promise for the volume.
//
// In a power diagram h is right to 15u of H, which may be more than h <= R |n|. With R at least all H/|n| too the terms
// are right to u R^3 (72/sin + 86 condition + 21), two an edge: beta |n_b| <= R / sin to 63u R / sin^2, X to u R (86
// condition + 6). Twice the bound above is more than that. The seed may be far from its cell, so the centroid may
// err by 2 R times the relative error of the volume.
#ifndef VOTESS_MEASURE_TETRAHEDRA_GLSL
#define VOTESS_MEASURE_TETRAHEDRA_GLSL

#include "measure/exact_planes.glsl"
#include "measure/moments.glsl"
#include "numbers/number.glsl"

// Returns (H / |n|)^2, see clip/filter.glsl.
float squared_size(float foot, float square) {
    const float size = max(foot, 1.0 - foot);
    return size * size * square;
}

// Returns the vertex of three planes.
Vector exact_vertex(ExactPlane a, ExactPlane b, ExactPlane c, inout Moments all) {
    const Vector ab = cross(a.n, b.n), bc = cross(b.n, c.n), ca = cross(c.n, a.n);
    const Number square_a = dot(a.n, a.n), square_b = dot(b.n, b.n), square_c = dot(c.n, c.n);
    const Number inverse_det = reciprocal(dot(a.n, bc));
    const Vector sum = plus(plus(times(bc, times(a.foot, square_a)), times(ca, times(b.foot, square_b))),
                            times(ab, times(c.foot, square_c)));
    const Vector vertex = times(sum, inverse_det);
    const vec3 near_vertex = vec3(rounded(vertex.x), rounded(vertex.y), rounded(vertex.z));
    all.farthest = max(all.farthest, dot(near_vertex, near_vertex));
    if (weighted != 0u) {
        all.farthest = max(all.farthest, squared_size(rounded(a.foot), rounded(square_a)));
        all.farthest = max(all.farthest, squared_size(rounded(b.foot), rounded(square_b)));
        all.farthest = max(all.farthest, squared_size(rounded(c.foot), rounded(square_c)));
    }
    const float norms = sqrt(rounded(square_a)) * sqrt(rounded(square_b)) * sqrt(rounded(square_c));
    all.error += 306.0 * (norms * rounded(inverse_det)) + 150.0;
    return vertex;
}

// Adds the two tetrahedra of a vertex on its edge of planes a and b, and their shares of the areas of the two faces.
void add_edge(ExactPlane a, ExactPlane b, Vector vertex, inout Moments all, inout Number area_a, inout Number area_b) {
    const Vector t = cross(a.n, b.n);
    const Number square_a = dot(a.n, a.n), square_b = dot(b.n, b.n), both = dot(a.n, b.n);
    const Number h_a = times(a.foot, square_a), h_b = times(b.foot, square_b);
    const Number over = reciprocal(dot(t, t)), along = dot(vertex, t);
    const Number alpha = times(minus(times(h_a, square_b), times(h_b, both)), over);
    const Number beta = times(minus(times(h_b, square_a), times(h_a, both)), over);
    const Number on_a = times(beta, along), on_b = times(alpha, along);  // areas, twice, and times |n|
    const Number part_a = times(a.foot, on_a), part_b = times(b.foot, on_b);
    const Number part = plus(part_a, part_b);
    all.sum = plus(all.sum, part);
    // The sum of the corners r_a or r_b, r_ab and X, in terms of n_a, n_b and X.
    all.first = plus(all.first, times(vertex, part));
    all.first = plus(all.first, times(a.n, plus(times(part, alpha), times(part_a, a.foot))));
    all.first = plus(all.first, times(b.n, plus(times(part, beta), times(part_b, b.foot))));
    all.error += 100.0 * rounded(square_a) * rounded(square_b) * rounded(over);
    if (want_geometry != 2u) return;
    area_a = plus(area_a, times(on_a, reciprocal(times(root(square_a), number(2.0)))));
    area_b = plus(area_b, times(on_b, reciprocal(times(root(square_b), number(2.0)))));
}

// Adds the tetrahedra of a vertex, and outputs its shares of the areas of their faces. The
// loop is not unrolled, because it needs the most registers of the measuring code.
void add_corner(uint vertex_number, inout Moments all, out Number areas[3]) {
    uint planes = planes_of_vertex(vertex_number);
    const Vector vertex = exact_vertex(exact_plane_at(plane_of(planes, 0)), exact_plane_at(plane_of(planes, 1)),
                                       exact_plane_at(plane_of(planes, 2)), all);
    Number area_a = number(0.0), area_b = number(0.0), area_c = number(0.0);
    [[dont_unroll]] for (int k = 0; k < 3; ++k) {
        add_edge(exact_plane_at(plane_of(planes, 0)), exact_plane_at(plane_of(planes, 1)), vertex, all, area_a, area_b);
        // Moves to the next edge; three moves restore the order.
        planes = pack_planes(plane_of(planes, 1), plane_of(planes, 2), plane_of(planes, 0));
        const Number first = area_a;
        area_a = area_b;
        area_b = area_c;
        area_c = first;
    }
    areas = Number[3](area_a, area_b, area_c);
}

void divide(Moments all) {
    volume = times(all.sum, reciprocal(number(6.0)));
    // A tetrahedron's centroid is a quarter of the sum of its corners.
    mass_center = times(all.first, times(reciprocal(all.sum), number(0.25)));
}

float rounding_error(Moments all, float radius) {
    const float error = all.error * radius * radius * (number_unit * radius * 0.334 + float(quantum) * (radius + 1.0) * 0.015);
    return float(quantum) * (radius + 1.0) * radius * radius * 13.5 + (weighted != 0u ? 2.0 * error : error);
}
float arm_of_centroid(Moments all, float radius) {
    return radius;
}

float rounding_error_of_areas(Moments all, float min_surface) {
    return 0.0;  // that of the volume bounds it
}

#endif

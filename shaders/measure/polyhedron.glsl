// Volume, centroid and areas of the faces of a finished cell in float32. Only planes and residuals are sums of two
// float32: Cramer's rule gives a vertex x0 in float32, the residuals h - n.x0 of its planes a step to x.
//
// With r_a the foot of the seed on face a, the edge of planes a and b from y to x adds (r_a - r_b).(y x x) to 6 V. Each
// edge counts half at both of its ends. D is y - x. The feet around a vertex cancel: their differences add up to 0. So a
// vertex that moves by e moves 6 V only by the sum of e.(D x (r_a - r_b)) over its edges, and no condition or angle of
// planes amplifies that. Moments and areas follow in the same way.
//
// Bounds, with u the unit roundoff, v that of sums (number_unit), R the farthest vertex, in a power diagram at least all
// H/|n| (clip/filter.glsl), and l = |r_a - r_b||D| of an edge:
// - A residual is right to 4v (H + |n||x|) and u of itself: h to 2^-41 H, n to 2^-44, 50u^2 (H + |n||x|) of low parts;
//   four times that where a device rounds otherwise. The step solves three planes right to u (37 condition + 6) of its
//   length: residuals are at most |n||step|, numerators and the determinant right to 8u of 1.16 P. So the vertex errs by
//       e = u |x| + condition (50u |step| + 25v R' + 3.2 quantum (R' + 1)) ,
//   where R' is R at this vertex. The last is the move of the rounded planes.
// - First and second order of e: l e + |r_a - r_b| e^2 at each end of each edge.
// - Roundings at each end of an edge: half of 3.46u |x| l for D and the cross product, and of 6u |r_a - r_b||D x x| for
//   r_a - r_b, the dot product and the sum of three edges. Sums over vertices have a low part.
// - A foot moves its face by 3u |r_a|, which is 3u of 6 V, because the seed is inside. The last operations on the sum
//   have 6u.
// - In a power diagram the seed may be outside. Vertices and feet are then relative to the middle of the cell: x rounds
//   once more, and a foot, from a residual there, moves its face by 11u |r_a| + 8v R.
// Together this is E for 6 V. The volume also changes by the move of the faces, see moments.glsl.
//
// The first moment 24 V c is (y x x).(r_a - r_b) (x + y + t / 2) + (y x x).t (r_a - r_b) / 2 an edge, t = r_a + r_b. A move
// e of a vertex changes it by at most 6 R l e. Its roundings are at most 11.5 R times those of 6 V: sums over lanes have 6u
// of terms of at most 4 R |r_a - r_b||D x x|. So the centroid errs by at most 2.9 R + |c| times the relative error of the
// volume, and |c| is at most 3/4 R. With half of 1e-5 for the volume that is less than 1e-5 of 2 R, the cell's size.
//
// An edge adds n.(y x x) / (2 |n|) to the area of a face. All areas together err by |D| e + 1.73u |x||D| + 1.5u |D x x| at
// each end of each edge, and by 7.5u of themselves from 1 / |n|. The surface is at least that of a ball of the same volume,
// 4.83 V^(2/3).
#ifndef VOTESS_MEASURE_POLYHEDRON_GLSL
#define VOTESS_MEASURE_POLYHEDRON_GLSL

#include "clip/filter.glsl"
#include "measure/exact_planes.glsl"
#include "measure/moments.glsl"
#include "numbers/number.glsl"
#include "numbers/real.glsl"

// Return n and h of a plane in float32, the same with its foot once the vertices are refined, and a refined vertex;
// defined where they are stored.
vec4 plane_in_float32(uint plane);
vec4 foot_plane_at(uint plane);
vec3 place_of_vertex(uint vertex);

// In a power diagram the seed may be far from its cell. So vertices and feet are relative to this, about the mean of the
// vertices.
vec3 middle = vec3(0.0);

// Returns the foot of the seed, or of the middle, on a plane: a factor of n.
float near_foot(uint plane, bool is_wall) {
    const vec4 p = plane_in_float32(plane);
    if (weighted == 0u) return is_wall ? p.w : 0.5;
    const ExactPlane exact = exact_plane_at(plane);
    return residual(exact.n, exact.h, middle) / dot(p.xyz, p.xyz);
}

// Returns (H / |n|)^2, see clip/filter.glsl.
float squared_size(float h, float square) {
    const float size = max(h, square - h);
    return size * size / square;
}

// Returns the vertex of three packed planes, and e.
vec4 refined_vertex(uint planes, inout Moments all) {
    const vec4 a = plane_in_float32(plane_of(planes, 0)), b = plane_in_float32(plane_of(planes, 1)),
               c = plane_in_float32(plane_of(planes, 2));
    vec3 ab = cross(a.xyz, b.xyz), bc = cross(b.xyz, c.xyz), ca = cross(c.xyz, a.xyz);
    const float inverse = 1.0 / dot(a.xyz, bc);
    const vec3 rough = (a.w * bc + b.w * ca + c.w * ab) * inverse;
    vec3 step = vec3(0.0);
    [[dont_unroll]] for (int k = 0; k < 3; ++k) {
        const ExactPlane plane = exact_plane_at(plane_of(planes, k));
        step += residual(plane.n, plane.h, rough) * bc;
        const vec3 next = ca;
        ca = ab;
        ab = bc;
        bc = next;
    }
    step *= inverse;
    const vec3 vertex = (weighted != 0u ? rough - middle : rough) + step;
    const float square = dot(vertex, vertex);
    float far = square;
    const float square_a = dot(a.xyz, a.xyz), square_b = dot(b.xyz, b.xyz), square_c = dot(c.xyz, c.xyz);
    if (weighted != 0u)
        far = max(dot(rough, rough) * 1.1, max(squared_size(a.w, square_a), max(squared_size(b.w, square_b), squared_size(c.w, square_c))));
    all.farthest = max(all.farthest, far);
    all.extent = max(all.extent, square);
    far = sqrt(far);
    const float condition = abs(sqrt(square_a * square_b * square_c) * inverse);
    return vec4(vertex, (weighted != 0u ? 2.0 : 1.0) * float_unit * sqrt(square) +
                            condition * (50.0 * float_unit * length(step) + 25.0 * number_unit * far +
                                         3.2 * float(quantum) * (far + 1.0)));
}

// Returns whether none of the three packed planes is 0.
bool has_no_zero(uint planes) {
    return ((planes + 0x7f7f7fu) & 0x808080u) == 0x808080u;
}

// Returns the other ends of the edges of planes 0 and 1, 1 and 2, 2 and 0 of a vertex: they miss its third plane. An end
// that is not found is the vertex itself.
uvec3 other_ends(uint vertex, uint planes, uint vertices) {
    const uint a = plane_of(planes, 0) * 0x10101u, b = plane_of(planes, 1) * 0x10101u, c = plane_of(planes, 2) * 0x10101u;
    uvec3 ends = uvec3(vertex);
    [[dont_unroll]] for (uint v = 0u; v < vertices; ++v) {
        const uint other = planes_of_vertex(v);
        const bool misses_a = has_no_zero(other ^ a), misses_b = has_no_zero(other ^ b),
                   misses_c = has_no_zero(other ^ c);
        if (misses_c && !misses_a && !misses_b) ends.x = v;
        if (misses_a && !misses_b && !misses_c) ends.y = v;
        if (misses_b && !misses_c && !misses_a) ends.z = v;
    }
    return ends;
}

// Adds what a vertex has of the volumes of its edges, and outputs its shares of the areas of its faces. corner: the
// vertex and e.
void add_corner(uint vertex, uint vertices, vec4 corner, inout Moments all, out Number areas[3]) {
    uint planes = planes_of_vertex(vertex);
    uvec3 ends = other_ends(vertex, planes, vertices);
    if (any(equal(ends, uvec3(vertex)))) all.error = 1e30;
    const vec3 x = corner.xyz;
    const float size = length(x);
    vec3 area = vec3(0.0), first = vec3(0.0);
    float sum = 0.0, spread = 0.0, lengths = 0.0, turns = 0.0, areas_of_edges = 0.0;
    [[dont_unroll]] for (int k = 0; k < 3; ++k) {
        const vec4 a = foot_plane_at(plane_of(planes, 0)), b = foot_plane_at(plane_of(planes, 1));
        const vec3 y = place_of_vertex(ends.x), half_edge = 0.5 * (y - x), moment = cross(half_edge, x);
        precise const vec3 foot_a = a.xyz * a.w, foot_b = b.xyz * b.w;
        const vec3 apart = foot_a - foot_b, both = foot_a + foot_b;
        const float part = dot(moment, apart), half_length = length(half_edge);
        sum += part;
        first += part * (x + y + 0.5 * both) + 0.5 * dot(moment, both) * apart;
        const float of_apart = length(apart), of_moment = length(moment);
        spread += of_apart * (half_length + corner.w);
        turns += of_apart * of_moment;
        if (want_geometry == 2u) {
            lengths += half_length + corner.w;
            areas_of_edges += of_moment;
            area.x += 0.5 * dot(moment, a.xyz) * inversesqrt(dot(a.xyz, a.xyz));
            area.y -= 0.5 * dot(moment, b.xyz) * inversesqrt(dot(b.xyz, b.xyz));
        }
        // Moves to the next edge; three moves restore the order.
        planes = planes >> 8 | planes << 16;
        ends = ends.yzx;
        area = area.yzx;
    }
    all.sum = plus(all.sum, sum);
    all.first = plus(all.first, first);
    all.error += spread * (2.0 * corner.w + 3.6 * float_unit * size) + 6.2 * float_unit * turns;
    all.area_error += lengths * (2.0 * corner.w + 3.6 * float_unit * size) + 3.1 * float_unit * areas_of_edges;
    areas = Number[3](number(area.x), number(area.y), number(area.z));
}

void divide(Moments all) {
    const float sum = rounded(all.sum), of_first = 0.25 / sum;
    volume = number(sum * (1.0 / 6.0));
    mass_center = vector(rounded(all.first) * of_first);
    if (weighted != 0u) mass_center = plus(mass_center, vector(middle));
}

float rounding_error(Moments all, float radius) {
    const float moved = float(quantum) * (radius + 1.0) * 13.5 * all.extent;
    const float error = moved + 0.17 * (all.error + 9.0 * float_unit * rounded(all.sum));
    if (weighted == 0u) return error;
    return error + (1.4 * float_unit * rounded(all.sum) + 101.0 * number_unit * radius * all.extent);
}
float arm_of_centroid(Moments all, float radius) {
    return 0.0;
}

float rounding_error_of_areas(Moments all, float min_surface) {
    return 1.02 * all.area_error + 7.5 * float_unit * min_surface;
}

#endif

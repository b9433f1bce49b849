// HEAD
#ifndef VOTESS_MEASURE_POLYHEDRON_GLSL
#define VOTESS_MEASURE_POLYHEDRON_GLSL

#include "clip/filter.glsl"
#include "measure/exact_planes.glsl"
#include "measure/moments.glsl"
#include "numbers/number.glsl"
#include "numbers/real.glsl"

// Return a refined vertex and n and foot of a plane in float32; defined where they are stored.
vec3 place_of_vertex(uint vertex);
vec4 near_plane_at(uint plane);

// Returns (H / |n|)^2, see clip/filter.glsl.
float squared_size(float h, float square) {
    const float size = max(h, square - h);
    return size * size / square;
}

// Returns the vertex of three packed planes, and e.
vec4 refined_vertex(uint planes, inout float farthest) {
    const ExactPlane a = exact_plane_at(plane_of(planes, 0)), b = exact_plane_at(plane_of(planes, 1)),
                     c = exact_plane_at(plane_of(planes, 2));
    const vec3 na = rounded(a.n), nb = rounded(b.n), nc = rounded(c.n);
    const vec3 ab = cross(na, nb), bc = cross(nb, nc), ca = cross(nc, na);
    const float inverse = 1.0 / dot(na, bc);
    const vec3 rough = (rounded(a.h) * bc + rounded(b.h) * ca + rounded(c.h) * ab) * inverse;
    const vec3 step =
        (residual(a.n, a.h, rough) * bc + residual(b.n, b.h, rough) * ca + residual(c.n, c.h, rough) * ab) * inverse;
    const vec3 vertex = rough + step;
    float far = dot(vertex, vertex);
    if (weighted != 0u) {
        far = max(far, squared_size(rounded(a.h), dot(na, na)));
        far = max(far, squared_size(rounded(b.h), dot(nb, nb)));
        far = max(far, squared_size(rounded(c.h), dot(nc, nc)));
    }
    farthest = max(farthest, far);
    far = sqrt(far);
    const float condition = abs(length(na) * length(nb) * length(nc) * inverse);
    return vec4(vertex, float_unit * length(vertex) +
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
    const uint planes = planes_of_vertex(vertex);
    uvec3 ends = other_ends(vertex, planes, vertices);
    if (any(equal(ends, uvec3(vertex)))) all.error = 1e30;
    vec4 a = near_plane_at(plane_of(planes, 0)), b = near_plane_at(plane_of(planes, 1)),
         c = near_plane_at(plane_of(planes, 2));
    const vec3 x = corner.xyz;
    const float size = length(x);
    vec3 area = vec3(0.0), first = vec3(0.0);
    float sum = 0.0, spread = 0.0, lengths = 0.0;
    [[dont_unroll]] for (int k = 0; k < 3; ++k) {
        const vec3 y = place_of_vertex(ends.x), half_edge = 0.5 * (y - x), moment = cross(half_edge, x);
        precise const vec3 foot_a = a.xyz * a.w, foot_b = b.xyz * b.w;
        const vec3 apart = foot_a - foot_b, both = foot_a + foot_b;
        const float part = dot(moment, apart), half_length = length(half_edge);
        sum += part;
        first += part * (x + y + 0.5 * both) + 0.5 * dot(moment, both) * apart;
        float bound = length(apart);
        if (weighted != 0u) bound += 0.3 * (length(foot_a) + length(foot_b));
        spread += bound * (half_length + corner.w);
        if (want_geometry == 2u) {
            lengths += half_length + corner.w;
            area.x += 0.5 * dot(moment, a.xyz) * inversesqrt(dot(a.xyz, a.xyz));
            area.y -= 0.5 * dot(moment, b.xyz) * inversesqrt(dot(b.xyz, b.xyz));
        }
        // Moves to the next edge; three moves restore the order.
        const vec4 next = a;
        a = b;
        b = c;
        c = next;
        ends = ends.yzx;
        area = area.yzx;
    }
    all.sum = plus(all.sum, number(sum));
    all.first = plus(all.first, Vector(number(first.x), number(first.y), number(first.z)));
    all.error += spread * (2.0 * corner.w + 10.1 * float_unit * size);
    all.area_error += lengths * (2.0 * corner.w + 6.6 * float_unit * size);
    areas = Number[3](number(area.x), number(area.y), number(area.z));
}

float rounding_error(Moments all, float radius) {
    return 0.17 * all.error + 4.0 * float_unit * abs(rounded(all.sum)) * 0.17;
}
float rounding_error_of_areas(Moments all, float min_surface) {
    return 1.02 * all.area_error + 7.5 * float_unit * min_surface;
}

#endif

// What tests/stages/gpu/gpu_filter.cpp runs: the filter of shaders/clip/filter.glsl on one vertex and one more seed. A case
// has 16 numbers of 64 bits: the seed, three more and the last one in units, the exponent of the unit of length in the
// low word, and in the high word 1 when coordinates have been rounded to units. Variant: CLIP_FLOAT64.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "invocations/index.glsl"

layout(push_constant) uniform Push { uint count; };
layout(std430, set = 0, binding = 2) readonly buffer Cases { uvec2 cases[]; };
layout(std430, set = 0, binding = 5) writeonly buffer Verdicts { uint verdicts[]; };

Plane plane_of(uint seed) {
    return bisector(difference(cases[seed], px), difference(cases[seed + 1u], py), difference(cases[seed + 2u], pz));
}

void main() {
    const uint number = linear_invocation();
    if (number >= count) return;
    const uint first = 16u * number;
    px = cases[first];
    py = cases[first + 1u];
    pz = cases[first + 2u];
    scale = uintBitsToFloat((127u - cases[first + 15u].x) << 23);
    quantum = cases[first + 15u].y != 0u ? real(2.0 * scale) : real(0);
    const Plane a = plane_of(first + 3u), b = plane_of(first + 6u), c = plane_of(first + 9u), d = plane_of(first + 12u);
    Vertex v;
    uint verdict = 0u;
    if (find_vertex(a, b, c, v) && !is_too_near(a) && !is_too_near(b) && !is_too_near(c) && !is_too_near(d)) {
        verdict = 1u;
        const real side = side_of(d, v.x, v.y, v.z), bound = side_bound(d, v.error);
        if (side > bound) verdict |= 2u;
        if (side < -bound) verdict |= 4u;
        // A box of no size, and all that leaves it out.
        if (!is_in_reach(v.x, v.y, v.z, v.error, d.x, d.x, d.y, d.y, d.z, d.z)) verdict |= 8u;
        const real square = fma(v.x, v.x, fma(v.y, v.y, v.z * v.z));
        if (is_secure(real(2) * d.h, security_radius_squared(square, v.error))) verdict |= 16u;
        vec3 down = vec3(0.0), up = vec3(0.0);
        extend_reach(vec3(v.x, v.y, v.z), float(v.error), down, up);
        const vec3 at = vec3(d.x, d.y, d.z);
        if (any(greaterThan(at, up)) || any(lessThan(at, -down))) verdict |= 32u;
    }
    verdicts[number] = verdict;
}

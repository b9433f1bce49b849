// For tests/stages/gpu/gpu_filter.cpp: the filter of shaders/clip/filter.glsl on one vertex and one more seed. A case
// has 23 numbers of 64 bits: the seed, three more and the last one in units; a number of two words; the five weights; the
// tilt in 2^TILT_BITS units, two numbers of two words. The low word of the number before the weights is the exponent of
// the unit of length. Its high word is 1 when coordinates and weights were rounded to units, plus twice the exponent of a
// unit of weight. Variant: CLIP_FLOAT64.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "invocations/index.glsl"

layout(push_constant) uniform Push { uint count; };
layout(std430, set = 0, binding = 2) readonly buffer Cases { uvec2 cases[]; };
layout(std430, set = 0, binding = 5) writeonly buffer Verdicts { uint verdicts[]; };

uint first;

real lighter_at(uint i) {
    const uint seed = first + 3u + 3u * i;
    return lighter_by(cases[first + 17u + i], cases[seed], cases[seed + 1u], cases[seed + 2u]);
}

Plane plane_at(uint i) {
    const uint seed = first + 3u + 3u * i;
    const real x = difference(cases[seed], px), y = difference(cases[seed + 1u], py), z = difference(cases[seed + 2u], pz);
    if (weighted != 0u) return bisector(x, y, z, lighter_at(i));
    return bisector(x, y, z);
}

void main() {
    const uint number = linear_invocation();
    if (number >= count) return;
    first = 23u * number;
    px = cases[first];
    py = cases[first + 1u];
    pz = cases[first + 2u];
    scale = uintBitsToFloat((127u - cases[first + 15u].x) << 23);
    const uint word = cases[first + 15u].y;
    quantum = (word & 1u) != 0u ? real(2.0 * scale) : real(0);
    pw = cases[first + 16u];
    set_center(vec3(ivec3(cases[first + 21u], cases[first + 22u].x)) * exp2(float(TILT_BITS)));
    tilt_length = real(length(vec3(tilt)) * 1.00001 * exp2(float(TILT_BITS)) * scale);
    weight_bits = word / 2u;
    weight_scale = scale * scale * uintBitsToFloat((127u + weight_bits) << 23);
    weight_quantum = weighted != 0u && (word & 1u) != 0u ? real(weight_scale) : real(0);
    quantum = (quantum + real(0.6) * weight_quantum) * (real(1) + tilt_length);
    prepare_bounds();
    const Plane a = plane_at(0u), b = plane_at(1u), c = plane_at(2u), d = plane_at(3u);
    const real heavier = weighted != 0u ? heavier_by(lighter_at(3u)) : real(0);
    max_heavier = max(heavier, real(0));
    Vertex v;
    bool certain;
    uint verdict = 0u;
    if (find_vertex(a, b, c, v, certain) > real(0) && certain && !is_too_near(a) && !is_too_near(b) && !is_too_near(c) && !is_too_near(d)) {
        verdict = 1u;
        const real side = side_of(d, v.x, v.y, v.z), bound = side_bound(d, v.error);
        if (side > bound) verdict |= 2u;
        if (side < -bound) verdict |= 4u;
        // A box of no size, and whether it is skipped.
        if (!is_in_reach(v.x, v.y, v.z, v.error, vec3(d.x, d.y, d.z), vec3(d.x, d.y, d.z), heavier)) verdict |= 8u;
        if (is_secure(key_of(d, real(0)), security_radius_squared(v.norm, v.error))) verdict |= 16u;
        vec3 down = vec3(0.0), up = vec3(0.0);
        extend_reach(vec3(v.x, v.y, v.z), float(v.error), down, up);
        const vec3 at = vec3(d.x, d.y, d.z);
        const float further = sqrt(float(max_heavier)) * 1.0001;
        if (any(greaterThan(at, up + further)) || any(lessThan(at, -down - further))) verdict |= 32u;
        const real radius = (v.norm + v.error) * real(1.00001);
        if (is_secure(d.norm * d.norm, cutting_distance_squared(radius, heavier))) verdict |= 64u;
        if (cannot_cut(d, radius)) verdict |= 128u;
    }
    verdicts[number] = verdict;
}

// For tests/stages/gpu/gpu_walls.cpp: the distances of walls of shaders/clip/walls.glsl from places in units, each with
// the exponent of its unit of length. It outputs the distance, the rough one and the plane's for each pair.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "clip/walls.glsl"
#include "invocations/index.glsl"

layout(push_constant) uniform Push { uint count; };
layout(std430, set = 0, binding = 2) readonly buffer Places { uvec2 places[]; };
layout(std430, set = 0, binding = 5) writeonly buffer Distances { uvec4 distances[]; };

void main() {
    const uint number = linear_invocation();
    if (number >= count) return;
    px = places[4u * number];
    py = places[4u * number + 1u];
    pz = places[4u * number + 2u];
    set_center(vec3(0.0));
    scale = uintBitsToFloat((127u - places[4u * number + 3u].x) << 23);
    const uint wall_count = has_walls != 0u ? uint(walls.length()) : 0u;
    for (uint i = 0u; i < wall_count; ++i) {
        const uint w = wall_in_turn(i);
        const Plane plane = wall_plane(w);
        distances[number * wall_count + w] =
            uvec4(wall_distance(walls[w]), floatBitsToUint(min_wall_distance(w, rough_place())), floatBitsToUint(plane.h));
    }
}

// The cells of the slice z = 0.5, colored by volume.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
layout(std430, binding = 0) readonly buffer Seeds { vec4 seeds[]; };
layout(std430, binding = 1) readonly buffer Cells { uvec4 cells[]; };       // status, row_begin, row_length, faces
layout(std430, binding = 2) readonly buffer Indices { int indices[]; };     // the rows of neighbors
layout(std430, binding = 3) readonly buffer Geometry { vec4 geometry[]; };  // centroid from the seed, volume
layout(location = 0) out vec4 color;

const uint CERTIFIED = 0u;

float distance_squared(vec3 a, vec3 b) {
    return dot(a - b, a - b);
}

// The cell that holds the point: from seed to neighbor as long as one is nearer. Any start leads there; a near one takes
// few steps, here the seed whose place is in the same cube of the lattice. The few cells that are left to
// Plan::resolve() have no row; their pixels get the cell next to them.
uint locate(vec3 point) {
    const uint side = push.side, count = side * side * side;
    const uvec3 cube = min(uvec3(point * float(side)), uvec3(side - 1u));
    uint here = cube.x + side * (cube.y + side * cube.z);
    for (uint tried = 0u; tried < count && cells[here].x != CERTIFIED; ++tried) here = (here + 1u) % count;
    float nearest = distance_squared(point, seeds[here].xyz);
    for (uint last = count; last != here;) {
        last = here;
        const uvec4 cell = cells[here];
        for (uint k = cell.y; k < cell.y + cell.z; ++k) {
            const int j = indices[k];
            const float d = distance_squared(point, seeds[j].xyz);
            if (d < nearest && cells[j].x == CERTIFIED) {
                nearest = d;
                here = uint(j);
            }
        }
    }
    return here;
}

// How far the point is, within the slice, from the nearest of the planes halfway to the neighbors.
float depth(uint here, vec3 point) {
    const vec3 seed = seeds[here].xyz;
    float least = 1.0;
    for (uint k = cells[here].y; k < cells[here].y + cells[here].z; ++k) {
        const vec3 to = seeds[indices[k]].xyz - seed;
        least = min(least, dot(0.5 * to - (point - seed), to) / max(length(to.xy), 1e-9));
    }
    return least;
}

void main() {
    const vec3 point = vec3(gl_FragCoord.xy / push.width, 0.5);
    const uint here = locate(point);
    const float share = geometry[here].w * float(push.side * push.side * push.side);  // of the mean volume
    const float warmth = clamp(0.5 + 0.5 * log2(max(share, 1e-6)), 0.0, 1.0);
    const vec3 small = vec3(0.10, 0.20, 0.45), middle = vec3(0.35, 0.65, 0.60), large = vec3(0.98, 0.80, 0.35);
    const vec3 shade = warmth < 0.5 ? mix(small, middle, 2.0 * warmth) : mix(middle, large, 2.0 * warmth - 1.0);
    color = vec4(shade * smoothstep(-0.5, 1.5, depth(here, point) * push.width), 1.0);
}

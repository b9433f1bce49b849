// The cells in perspective, colored by volume, with a soft light from one side. Gray: cells that votess left to
// resolve().
#version 450
#extension GL_GOOGLE_include_directive : require
#include "push.h"

layout(push_constant) uniform Push { DrawPush push; };
layout(location = 0) out vec4 pixel;

#include "cells.glsl"

const float AHEAD = 1e4;

// Where a ray is inside the unit box: from x to y, if x < y.
vec2 inside_box(vec3 origin, vec3 direction) {
    const vec3 slope = mix(direction, vec3(1e-9), lessThan(abs(direction), vec3(1e-9)));
    const vec3 a = -origin / slope, b = (1.0 - origin) / slope;
    const vec3 near = min(a, b), far = max(a, b);
    return vec2(max(max(near.x, near.y), max(near.z, 0.0)), min(min(far.x, far.y), min(far.z, AHEAD)));
}

// The wall that a point lies on, by its outward normal.
vec3 wall_normal(vec3 point) {
    const vec3 from_middle = point - 0.5;
    const vec3 size = abs(from_middle);
    if (size.x >= size.y && size.x >= size.z) return vec3(sign(from_middle.x), 0.0, 0.0);
    return size.y >= size.z ? vec3(0.0, sign(from_middle.y), 0.0) : vec3(0.0, 0.0, sign(from_middle.z));
}

// Linear colors; each doubling of the volume is a quarter of the scale, whose middle is the mean.
vec3 color_of_volume(float volume) {
    const vec3 scale[5] = vec3[](vec3(0.040, 0.024, 0.150), vec3(0.020, 0.145, 0.330), vec3(0.110, 0.440, 0.400),
                                 vec3(0.900, 0.560, 0.170), vec3(0.740, 0.110, 0.080));
    const float x = clamp(0.5 + 0.25 * log2(volume * float(push.count)), 0.0, 1.0) * 4.0;
    const int step = min(int(x), 3);
    return mix(scale[step], scale[step + 1], x - float(step));
}

// Whether a ray from a face outwards meets no solid cell within `reach`. `cell` is the one outside of the face.
bool is_open(int cell, vec3 point, vec3 direction, float reach) {
    if (cell == NONE) return true;  // on a wall, and the box is convex
    return trace(cell, point, direction, min(inside_box(point, direction).y, reach)).cell == NONE;
}

vec3 shade(Hit hit, vec3 point, vec3 normal, float distance, uint sample_id) {
    // Directions spread evenly over samples: by the golden angle.
    const float turn = 2.39996323 * float(sample_id);
    const float share = (float(sample_id) + 0.5) / float(push.samples * push.samples);
    const vec3 disk = vec3(sqrt(share) * cos(turn), sqrt(share) * sin(turn), sqrt(1.0 - share));
    const vec3 side = normalize(cross(normal, abs(normal.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    const vec3 around = mat3(side, cross(normal, side), normal) * disk;
    const vec3 light = normalize(push.light.xyz + 0.05 * vec3(disk.xy, disk.x - disk.y));

    const float facing = dot(normal, light);
    const bool lit = facing > 0.0 && is_open(hit.from, point, light, AHEAD);
    const bool open = is_open(hit.from, point, around, push.light.w);
    const float sky = (open ? 1.0 : 0.3) * (0.7 + 0.3 * normal.z);
    const vec3 arriving = 0.72 * sky * vec3(0.88, 0.94, 1.0) + (lit ? 1.0 * facing : 0.0) * vec3(1.0, 0.95, 0.86);

    const bool has_row = certified(hit.cell);
    const vec3 surface = has_row ? color_of_volume(geometry[hit.cell].w) : vec3(0.35);
    const float width = push.forward.w * push.up.w * distance;
    const int cell = has_row ? hit.cell : hit.from;
    const float edge = cell == NONE ? 1.0 : to_edge(cell, has_row ? hit.from : hit.cell, point, normal);
    return mix(0.16, 1.0, smoothstep(0.3 * width, 0.7 * width, edge)) * surface * arriving;
}

vec3 background(vec2 at) {
    const float away = length(at - vec2(0.0, 0.1));
    return mix(vec3(0.93, 0.95, 0.97), vec3(0.55, 0.63, 0.72), clamp(0.15 + 0.55 * away, 0.0, 1.0));
}

struct View {
    vec3 start;      // where the ray comes into the box
    vec3 direction;
    float distance;  // from the eye to the start
    Hit hit;
};

// The first solid cell in a direction. `at`: from the picture's middle, half of the height being 1.
View view(vec2 at) {
    const vec2 slope = push.eye.w * vec2(at.x, -at.y);
    View seen;
    seen.hit = Hit(NONE, NONE, 0.0);
    seen.direction = normalize(push.forward.xyz + slope.x * push.right.xyz + slope.y * push.up.xyz);
    const vec2 within = inside_box(push.eye.xyz, seen.direction);
    // From here on the ray begins at the box, where float32 is finer.
    seen.distance = within.x;
    seen.start = push.eye.xyz + within.x * seen.direction;
    if (within.x >= within.y) return seen;
    const int first = locate(seen.start);
    if (first == NONE) {
        seen.hit.cell = UNKNOWN;
    } else {
        seen.hit = trace(first, seen.start, seen.direction, within.y - within.x);
    }
    return seen;
}

// The color of what is seen, in linear light.
vec3 look(vec2 at, uint sample_id) {
    const View seen = view(at);
    const Hit hit = seen.hit;
    if (hit.cell == NONE) return background(at);
    if (hit.cell == UNKNOWN) return vec3(0.35);
    const vec3 point = seen.start + hit.t * seen.direction;
    const vec3 normal = hit.from == NONE ? wall_normal(point) : normalize(seeds[hit.from].xyz - seeds[hit.cell].xyz);
    return shade(hit, point, normal, seen.distance + hit.t, sample_id);
}

// In units of half of the height, from the middle.
vec2 in_picture(vec2 inside_pixel) {
    return (floor(gl_FragCoord.xy) + inside_pixel) * 2.0 / push.height - vec2(push.right.w, 1.0);
}

void main() {
    if (push.samples == 0u) {
        const uint number = uint(view(in_picture(vec2(0.5))).hit.cell + 1);
        pixel = vec4(number & 0xffu, number >> 8 & 0xffu, number >> 16 & 0xffu, number >> 24) / 255.0;
        return;
    }
    vec3 sum = vec3(0.0);
    for (uint s = 0u; s < push.samples * push.samples; ++s) {
        sum += look(in_picture((vec2(s % push.samples, s / push.samples) + 0.5) / float(push.samples)), s);
    }
    pixel = vec4(pow(sum / float(push.samples * push.samples), vec3(1.0 / 2.2)), 1.0);
}

// picture_occlusion: tells how much of the light from all around nearby surfaces leave to a pixel.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/picture.h"

layout(push_constant) uniform Push { PicturePush push; };
layout(binding = 0) uniform sampler2D surfaces;
layout(location = 0) out float open_part;

const int samples = 20;
const float turn = 2.39996323;  // golden angle: samples of a spiral never line up
const float bias = 0.12;        // cosine that flat surfaces reach by rounding
const float most_pixels = 160.0;

vec3 place_of(ivec2 pixel, float away) {
    return vec3((vec2(pixel) + 0.5 - push.lens.xy) * away / push.lens.z, away);
}

void main() {
    const ivec2 pixel = ivec2(gl_FragCoord.xy);
    const ivec2 last = textureSize(surfaces, 0) - 1;
    const vec4 here = texelFetch(surfaces, pixel, 0);
    open_part = 1.0;
    if (here.w == 0.0 || push.sky.w == 0.0) return;
    const vec3 place = place_of(pixel, here.w);
    const float radius = push.sky.w;
    const float pixels = min(radius * push.lens.z / here.w, most_pixels);
    // Each pixel of a block of 4 x 4, over which the light is then averaged, has another spiral.
    const int step = (pixel.x & 3) * 4 + ((pixel.y & 3) * 7 & 15);
    const float first = float(step & 15) * (6.2831853 / 16.0);
    float hidden = 0.0;
    for (int i = 0; i < samples; ++i) {
        const float angle = first + turn * float(i);
        const float along = (float(i) + 0.5) / float(samples);
        const ivec2 at = clamp(pixel + ivec2(round(pixels * along * vec2(cos(angle), sin(angle)))), ivec2(0), last);
        const float away = texelFetch(surfaces, at, 0).w;
        if (away == 0.0) continue;
        const vec3 to = place_of(at, away) - place;
        const float square = dot(to, to);
        if (square == 0.0) continue;
        const float reach = max(0.0, 1.0 - square / (radius * radius));
        hidden += reach * max(0.0, dot(to, here.xyz) * inversesqrt(square) - bias);
    }
    open_part = clamp(1.0 - 1.7 * hidden / float(samples), 0.0, 1.0);
}

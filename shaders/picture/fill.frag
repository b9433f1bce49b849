// picture_fill: draws a polygon with lines along its edges; with LIT as a surface in space, else in its plain color.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/picture.h"

layout(push_constant) uniform Push { PicturePush push; };
layout(location = 0) flat in vec3 normal;
layout(location = 1) flat in vec4 color;
layout(location = 2) in float edge;
layout(location = 0) out vec4 pixel;

#ifdef LIT
layout(binding = 0) uniform sampler2D surfaces;
layout(binding = 1) uniform sampler2D occlusion;

// The mean over a block of pixels, without those of other surfaces.
float open_part() {
    const ivec2 at = ivec2(gl_FragCoord.xy);
    const ivec2 last = textureSize(surfaces, 0) - 1;
    const float away = 1.0 / gl_FragCoord.w;
    float sum = 0.0, weight = 0.0;
    for (int y = -2; y < 2; ++y) {
        for (int x = -2; x < 2; ++x) {
            const ivec2 near = clamp(at + ivec2(x, y), ivec2(0), last);
            const float other = texelFetch(surfaces, near, 0).w;
            if (abs(other - away) > 0.1 * push.sky.w) continue;
            sum += texelFetch(occlusion, near, 0).r;
            weight += 1.0;
        }
    }
    return weight > 0.0 ? sum / weight : 1.0;
}

vec3 shade(vec3 surface) {
    const vec3 n = normalize(normal);
    const float toward = dot(n, push.light.xyz);
    const float direct = max(0.0, 0.4 + 0.6 * toward);  // soft: light comes from an area
    const float around = 0.5 + 0.5 * dot(n, push.sky.xyz);
    const float open = open_part();
    const float light = 0.60 * direct * mix(1.0, open, 0.4) + (0.42 + 0.16 * around) * open;
    return min(surface * light, vec3(1.0));
}
#else
vec3 shade(vec3 surface) {
    return surface;
}
#endif

vec3 decode(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

vec3 encode(vec3 c) {
    return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

void main() {
    const vec3 shaded = encode(shade(decode(color.rgb)));
    // `edge` falls from 1 to 0 over so many pixels.
    const float slope = length(vec2(dFdx(edge), dFdy(edge)));
    float line = 0.0;
    if (slope > 0.0 && push.light.w > 0.0) {
        const float size = 1.0 / slope;
        const float presence = clamp(0.05 * size / push.light.w - 0.1, 0.0, 1.0);  // none where cells are as small as lines
        line = presence * (1.0 - smoothstep(push.light.w - 0.5, push.light.w + 0.6, edge * size));
    }
    pixel = vec4(mix(shaded, shaded * 0.16, 0.85 * line), color.a);
}

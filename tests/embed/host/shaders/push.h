// Push constants of the host's shaders. Included by GLSL and by C++; no member needs padding.
#ifndef VOTESS_HOST_PUSH_H
#define VOTESS_HOST_PUSH_H

#ifdef __cplusplus
#include <array>
#include <cstdint>
namespace host {
using uint = std::uint32_t;
using vec4 = std::array<float, 4>;
#endif

struct MovePush {
    uint count;
    float time;
    float step;  // from the last frame to this one
};

struct DrawPush {
    vec4 eye;      // position; w: tangent of half the view's height
    vec4 right;    // unit vector; w: width over height
    vec4 up;       // unit vector; w: angle of a pixel
    vec4 forward;  // unit vector; w: width of the lines, pixels
    vec4 light;    // unit vector towards the light; w: how far surfaces darken each other
    vec4 cut;      // cells with seeds beyond this corner are taken away; w: and those larger than this
    uint count;    // seeds
    uint samples;  // per pixel along each axis; 0: the number of the cell instead of a color, plus 1
    float height;  // pixels
};

#ifdef __cplusplus
}  // namespace host
#endif

#endif

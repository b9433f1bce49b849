// The push constants of all shaders of pictures. Included by GLSL and by C++.
#ifndef VOTESS_SHADERS_PICTURE_H
#define VOTESS_SHADERS_PICTURE_H

#ifdef __cplusplus
#include <glm/vec4.hpp>
namespace votess::gpu {
using vec4 = glm::vec4;
#endif

struct PicturePush {
    vec4 matrix[4];  // columns: from positions to the picture's clip space
    vec4 tile;       // from the picture's clip space to that of the part drawn: scales xy, offsets zw
    vec4 light;      // direction towards the light; w: half the width of edge lines, pixels
    vec4 sky;        // direction upwards; w: reach of occlusion, units of positions, 0 = none
    vec4 lens;       // xy: pixel of the part in which the origin is seen; z: focal length in pixels
};

#ifdef __cplusplus
static_assert(sizeof(PicturePush) == 128);
}  // namespace votess::gpu
#endif

#endif

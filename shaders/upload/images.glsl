// Images of the seeds of a periodic box: by at most one side along each axis, within the larger box around it.
#ifndef VOTESS_UPLOAD_IMAGES_GLSL
#define VOTESS_UPLOAD_IMAGES_GLSL

#include "numbers/int64.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { ImagesPush push; };

#include "upload/points.glsl"

bool is_periodic(int axis) {
    return (push.periodic & (1u << axis)) != 0u;
}
// Returns whether the seed, moved down or up by a side, lies in the larger box.
bool has_lower_image(uvec2 x, int axis) {
    return is_periodic(axis) && !less64(x, push.side[axis]);
}
bool has_upper_image(uvec2 x, int axis) {
    return is_periodic(axis) && !less64(push.extent[axis], add64(x, push.side[axis]));
}

uint images_along(uvec2 x, int axis) {
    return (has_lower_image(x, axis) ? 1u : 0u) + (has_upper_image(x, axis) ? 1u : 0u);
}

uint images_of(uvec2 x, uvec2 y, uvec2 z) {
    if (x.y == NO_COORDINATE) return 0u;
    return (1u + images_along(x, 0)) * (1u + images_along(y, 1)) * (1u + images_along(z, 2)) - 1u;
}

#endif

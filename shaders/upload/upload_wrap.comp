// upload: brings seeds into the periodic box, by whole sides, and counts the images of each.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "shared/interface.h"
#include "shared/layout.h"
#include "upload/images.glsl"

layout(std430, binding = BINDING_SCAN_DATA) writeonly buffer Counts { uint counts[]; };

// Upload has refused seeds that are farther away than a side, both rounded as doubles; so it may be nearly two sides.
uvec2 wrapped(uvec2 x, int axis) {
    if (!is_periodic(axis)) return x;
    uvec2 from = subtract64(x, push.lower[axis]);
    for (int i = 0; i < 2; ++i)
        if ((from.y & 0x80000000u) != 0u) from = add64(from, push.side[axis]);
    for (int i = 0; i < 2; ++i)
        if (!less64(from, push.side[axis])) from = subtract64(from, push.side[axis]);
    return add64(from, push.lower[axis]);
}

void main() {
    const uint seed = linear_invocation();
    if (seed >= push.count) return;
    uvec2 x = points_x[seed], y = points_y[seed], z = points_z[seed];
    if (x.y != NO_COORDINATE) {
        points_x[seed] = x = wrapped(x, 0);
        points_y[seed] = y = wrapped(y, 1);
        points_z[seed] = z = wrapped(z, 2);
    }
    counts[seed] = images_of(x, y, z);
}

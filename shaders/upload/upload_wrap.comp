// upload: wraps seeds into the periodic box, by whole sides, and counts the images of each.
//
// Variant: TRICLINIC does so in a triclinic box. Where it cannot decide on which side of a face a seed lies, no cell is
// certified: rows would have shifts from another place.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "shared/interface.h"
#include "shared/layout.h"
#ifdef TRICLINIC
#include "upload/lattice.glsl"
#else
#include "upload/images.glsl"
#endif

layout(std430, binding = BINDING_SCAN_DATA) writeonly buffer Counts { uint counts[]; };

#ifdef TRICLINIC
layout(std430, binding = BINDING_RUN_STATE) buffer State { RunState state; };

void wrap(inout uvec2 x, inout uvec2 y, inout uvec2 z) {
    bool unsure = false;
    const bool exact = state.lossy == 0u;
    const int a = steps_below(x, y, z, 0u, exact, unsure), b = steps_below(x, y, z, 1u, exact, unsure);
    const int c = steps_below(x, y, z, 2u, exact, unsure);
    x = moved(x, -a, -b, -c, 0u);
    y = moved(y, -a, -b, -c, 1u);
    z = moved(z, -a, -b, -c, 2u);
    if (unsure) state.incomplete = 1u;
}
#else
// Upload refused seeds that are farther away than a side, in rounded doubles. So a seed may be nearly two sides away.
uvec2 wrapped(uvec2 x, int axis) {
    if (!is_periodic(axis)) return x;
    uvec2 from = subtract64(x, push.lower[axis]);
    for (int i = 0; i < 2; ++i)
        if ((from.y & 0x80000000u) != 0u) from = add64(from, push.side[axis]);
    for (int i = 0; i < 2; ++i)
        if (!less64(from, push.side[axis])) from = subtract64(from, push.side[axis]);
    return add64(from, push.lower[axis]);
}

void wrap(inout uvec2 x, inout uvec2 y, inout uvec2 z) {
    x = wrapped(x, 0);
    y = wrapped(y, 1);
    z = wrapped(z, 2);
}
#endif

void main() {
    const uint seed = linear_invocation();
    if (seed >= push.count) return;
    uvec2 x = point_x(seed), y = point_y(seed), z = point_z(seed);
    if (x.y != NO_COORDINATE) {
        wrap(x, y, z);
        put_point(seed, x, y, z);
    }
    counts[seed] = images_of(x, y, z);
}

// Images of the seeds of a triclinic box: all that lie within the larger box around it.
#ifndef VOTESS_UPLOAD_LATTICE_GLSL
#define VOTESS_UPLOAD_LATTICE_GLSL

#include "numbers/int128.glsl"
#include "numbers/int64.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { ImagesPush push; };
layout(std430, binding = BINDING_LATTICE) readonly buffer Lattice { LatticeData lattice; };

#include "upload/points.glsl"

uvec4 signed_product(uvec2 a, uvec2 b) {
    const uvec4 p = product128(magnitude64(a), magnitude64(b));
    return is_negative(a) != is_negative(b) ? negate128(p) : p;
}

uvec2 moved(uvec2 x, int a, int b, int c, uint axis) {
    x = add64(x, times64(a, lattice.vector[axis]));
    x = add64(x, times64(b, lattice.vector[3u + axis]));
    return add64(x, times64(c, lattice.vector[6u + axis]));
}

// Returns which multiple of edge j is below the place. Sets `unsure` where rounding may change it.
int steps_below(uvec2 x, uvec2 y, uvec2 z, uint j, bool exact, inout bool unsure) {
    const uvec2 d[3] = uvec2[3](subtract64(x, lattice.origin[0]), subtract64(y, lattice.origin[1]),
                                subtract64(z, lattice.origin[2]));
    uvec4 sum = uvec4(0);
    bool on_face = exact;
    for (uint k = 0u; k < 3u; ++k) {
        sum = add128(sum, signed_product(d[k], lattice.dual[3u * j + k]));
        on_face = on_face && (d[k] == uvec2(0) || (lattice.zeros >> (3u * j + k) & 1u) != 0u);
    }
    if (on_face) return 0;
    const uint n = lattice.to_fraction;
    const uvec2 f = uvec2((sum.y >> (n - 32u)) | (sum.z << (64u - n)), (sum.z >> (n - 32u)) | (sum.w << (64u - n)));
    const uint high_bits = uint(FRACTION_BITS - 32);
    const uvec2 part = uvec2(f.x, f.y & ((1u << high_bits) - 1u));
    unsure = unsure || less64(part, lattice.unsure) ||
             less64(subtract64(uvec2(0u, 1u << high_bits), lattice.unsure), part);
    return int(f.y) >> high_bits;
}

bool is_inside(uvec2 x, uvec2 y, uvec2 z) {
    return !less64(push.extent[0], x) && !less64(push.extent[1], y) && !less64(push.extent[2], z);
}

// Counts the images of a seed up to number `last`, and outputs the place and shift of that one.
uint count_images(inout uvec2 x, inout uvec2 y, inout uvec2 z, uint last, out ivec3 shift) {
    const uvec2 sx = x, sy = y, sz = z;
    uint count = 0u;
    shift = ivec3(0);
    for (int a = lattice.least[0]; a <= lattice.last[0]; ++a)
        for (int b = lattice.least[1]; b <= lattice.last[1]; ++b)
            for (int c = lattice.least[2]; c <= lattice.last[2]; ++c) {
                if (a == 0 && b == 0 && c == 0) continue;
                x = moved(sx, a, b, c, 0u);
                y = moved(sy, a, b, c, 1u);
                z = moved(sz, a, b, c, 2u);
                if (!is_inside(x, y, z)) continue;
                shift = ivec3(a, b, c);
                if (count++ == last) return count;
            }
    return count;
}

uint images_of(uvec2 x, uvec2 y, uvec2 z) {
    if (x.y == NO_COORDINATE) return 0u;
    ivec3 shift;
    return count_images(x, y, z, 0xffffffffu, shift);
}

#endif

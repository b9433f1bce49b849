// sort: finds the place of each point along a Hilbert curve through a grid with 2^bits blocks along the box's longest
// side. Rounding moves the borders of blocks, but equal points have equal keys.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { KeyPush push; };
layout(std430, binding = BINDING_KEYS_OUT) writeonly buffer Keys { uvec2 keys[]; };
layout(std430, binding = BINDING_INDEX_OUT) writeonly buffer Index { uint index[]; };

#include "upload/points.glsl"

// Interleaves ten bits of each axis, half of KEY_BITS_PER_AXIS.
uint interleave(uvec3 axes) {
    uvec3 v = axes & 0x3ffu;
    v = (v | (v << 16)) & 0x030000ffu;
    v = (v | (v << 8)) & 0x0300f00fu;
    v = (v | (v << 4)) & 0x030c30c3u;
    v = (v | (v << 2)) & 0x09249249u;
    return (v.x << 2) | (v.y << 1) | v.z;
}

// Returns the index along the curve, with its bits spread over the axes (Skilling, Programming the Hilbert curve, AIP
// Conf. Proc. 707, 2004).
uvec3 hilbert_transposed(uvec3 axes, uint bits) {
    for (uint q = 1u << (bits - 1u); q > 1u; q >>= 1) {
        const uint low = q - 1u;
        for (int i = 0; i < 3; ++i) {
            if ((axes[i] & q) != 0u) {
                axes.x ^= low;
            } else {
                const uint exchange = (axes.x ^ axes[i]) & low;
                axes.x ^= exchange;
                axes[i] ^= exchange;
            }
        }
    }
    axes.y ^= axes.x;
    axes.z ^= axes.y;
    uint flip = 0u;
    for (uint q = 1u << (bits - 1u); q > 1u; q >>= 1)
        if ((axes.z & q) != 0u) flip ^= q - 1u;
    return axes ^ flip;
}

void main() {
    const uint point = linear_invocation();
    if (point >= push.total) return;
    const uint most = (1u << push.bits) - 1u;
    uvec3 block = uvec3(most);  // points without coordinates go to the end of the curve
    if (point_x(point).y != NO_COORDINATE) {
        const vec3 high = vec3(point_x(point).y, point_y(point).y, point_z(point).y);
        block = min(uvec3(high * push.blocks_per_unit), uvec3(most));
    }
    const uvec3 h = hilbert_transposed(block, push.bits);
    keys[point] = uvec2(interleave(h), interleave(h >> 10));
    index[point] = point;
}

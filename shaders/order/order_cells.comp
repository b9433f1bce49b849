// order: gives status, row lengths, volumes and centroids of a frame arrays of their own. The lengths become offsets by a
// scan; one more, 0, follows them.
//
// Variant: FLOAT64 reads seeds and writes centroids in float64.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/order.h"

#ifdef FLOAT64
#define REAL double
#define REAL_BITS uvec2
#define NO_REAL uvec2(0u, 0x7ff80000u)
#define bits_of(x) unpackDouble2x32(x)
#else
#define REAL float
#define REAL_BITS uint
#define NO_REAL 0x7fc00000u
#define bits_of(x) floatBitsToUint(x)
#endif

layout(push_constant) uniform Push { OrderPush push; };
layout(std430, binding = BINDING_RAW) readonly buffer Raw { REAL raw[]; };
layout(std430, binding = BINDING_CELLS) readonly buffer Cells { FrameCell cells[]; };
layout(std430, binding = BINDING_GEOMETRY_OUT) readonly buffer GeometryOut { vec4 geometry_out[]; };
layout(std430, binding = BINDING_PART_INFO) writeonly buffer Statuses { uint statuses[]; };
layout(std430, binding = BINDING_PART_OFFSETS) writeonly buffer PartOffsets { uint part_offsets[]; };
layout(std430, binding = BINDING_GEOMETRY) writeonly buffer Volumes { float volumes[]; };
layout(std430, binding = BINDING_PART_GEOMETRY) writeonly buffer Centroids { REAL_BITS centroids[]; };

void main() {
    const uint cell = linear_invocation();
    if (cell > push.count) return;
    if (push.neighbors != 0u) part_offsets[cell] = cell < push.count ? cells[cell].row_length : 0u;
    if (cell == push.count) return;
    const uint status = cells[cell].status;
    statuses[cell] = status;
    const bool done = status == STATUS_CERTIFIED;
    if (push.volumes != 0u) volumes[cell] = done ? geometry_out[cell].w : 0.0;
    if (push.centroids == 0u) return;
    for (uint k = 0u; k < 3u; ++k)
        centroids[3u * cell + k] = done ? bits_of(raw[3u * cell + k] + REAL(geometry_out[cell][k])) : NO_REAL;
}

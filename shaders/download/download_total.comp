// download: adds the entries of a chunk to the total, where the rows of the next chunk begin. The total stays at the
// largest number when it would overflow.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { FramePush push; };
layout(std430, binding = BINDING_HEADER) buffer Header { FrameHeader header; };

#include "shared/chunk.glsl"

void main() {
    if (gl_GlobalInvocationID.x != 0u) return;
    const uint last = push.cell_count - 1u, total = word_of(WORDS_ROW_OFFSET, last) + word_of(WORDS_ROW_LENGTH, last);
    chunk.row_base = total > 0xffffffffu - chunk.row_base ? 0xffffffffu : chunk.row_base + total;
    header.entries = chunk.row_base;
}

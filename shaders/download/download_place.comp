// download: stores status, length and geometry of each cell of a chunk by member, and where its row begins in the rows
// out. A Number of either kind moves as two words.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "download/row_fits.glsl"
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { FramePush push; };
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_GEOMETRY) readonly buffer Geometry { uvec4 geometry[]; };
layout(std430, binding = BINDING_PART_INFO) writeonly buffer PartInfo { uint part_info[]; };
layout(std430, binding = BINDING_PART_LENGTH) writeonly buffer PartLength { uint part_length[]; };
layout(std430, binding = BINDING_PART_BEGIN) writeonly buffer PartBegin { uint part_begin[]; };
layout(std430, binding = BINDING_PART_GEOMETRY) writeonly buffer PartGeometry { uvec4 part_geometry[]; };

#include "shared/chunk.glsl"

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.cell_count) return;
    const uint member = seed_input[push.first_cell + cell] & INDEX_MASK;
    if (member >= push.own_count) return;
    part_info[member] = word_of(WORDS_INFO, cell);
    if (push.neighbors != 0u) {
        part_length[member] = word_of(WORDS_ROW_LENGTH, cell);
        part_begin[member] = chunk.row_base + word_of(WORDS_ROW_OFFSET, cell);
    }
    if (push.geometry == 0u) return;
    part_geometry[2u * member] = geometry[2u * cell];
    part_geometry[2u * member + 1u] = geometry[2u * cell + 1u];
}

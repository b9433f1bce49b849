// download: the rows of a chunk one after the other, each in ascending order, and the areas beside them.
//
// Variants: AREA is the type of an area as it lies in memory, uint for float32, uvec2 for float64; without it there are
// no areas.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/bindings.h"
#include "shared/layout.h"

layout(local_size_x_id = CONSTANT_LOCAL_SIZE) in;
layout(push_constant) uniform Push { RowsPush push; };
layout(std430, binding = BINDING_ROW_LENGTH) readonly buffer RowLength { uint row_length[]; };
layout(std430, binding = BINDING_ROW_PLACE) readonly buffer RowPlace { uint row_place[]; };
layout(std430, binding = BINDING_ROWS) readonly buffer Rows { int rows[]; };
layout(std430, binding = BINDING_SECOND_ROWS) readonly buffer SecondRows { int second_rows[]; };
layout(std430, binding = BINDING_ROW_OFFSETS) readonly buffer RowOffsets { uint row_offsets[]; };
layout(std430, binding = BINDING_CHUNK_STATE) readonly buffer Chunk { ChunkState chunk; };
layout(std430, binding = BINDING_ROWS_OUT) writeonly buffer RowsOut { int rows_out[]; };
#ifdef AREA
layout(std430, binding = BINDING_AREAS) readonly buffer Areas { AREA areas[]; };
layout(std430, binding = BINDING_SECOND_AREAS) readonly buffer SecondAreas { AREA second_areas[]; };
layout(std430, binding = BINDING_AREAS_OUT) writeonly buffer AreasOut { AREA areas_out[]; };
#endif

#include "lib/linear.glsl"
#include "lib/rows.glsl"

int entry(uint place, uint i) {
    const uint column = place & ~SECOND_TIER_BIT;
    return (place & SECOND_TIER_BIT) != 0u ? second_rows[i * push.second_row_stride + column]
                                           : rows[i * push.row_stride + column];
}

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.cell_count) return;
    const uint length = row_length[cell], place = row_place[cell];
    if (!row_fits(chunk.row_base, row_offsets[cell], length, push.capacity)) return;
    const uint offset = chunk.row_base + row_offsets[cell];
    for (uint i = 0u; i < length; ++i) {
        const int id = entry(place, i);
        uint rank = 0u;
        for (uint j = 0u; j < length; ++j)
            if (entry(place, j) < id) ++rank;
        rows_out[offset + rank] = id;
#ifdef AREA
        const uint column = place & ~SECOND_TIER_BIT;
        if ((place & SECOND_TIER_BIT) != 0u)
            areas_out[offset + rank] = second_areas[i * push.second_row_stride + column];
        else
            areas_out[offset + rank] = areas[i * push.row_stride + column];
#endif
    }
}

// download: puts the rows of a chunk one after the other, each in ascending order.
//
// Variants: AREAS puts areas beside the rows; any Number moves as two words. SHIFTS gives images the index of their seed
// and puts shifts beside the rows, which are in the order of both.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "download/row_fits.glsl"
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { RowsPush push; };
layout(std430, binding = BINDING_ROW_LENGTH) readonly buffer RowLength { uint row_length[]; };
layout(std430, binding = BINDING_ROW_PLACE) readonly buffer RowPlace { uint row_place[]; };
layout(std430, binding = BINDING_ROWS) readonly buffer Rows { int rows[]; };
layout(std430, binding = BINDING_SECOND_ROWS) readonly buffer SecondRows { int second_rows[]; };
layout(std430, binding = BINDING_ROW_OFFSETS) readonly buffer RowOffsets { uint row_offsets[]; };
layout(std430, binding = BINDING_CHUNK_STATE) readonly buffer Chunk { ChunkState chunk; };
layout(std430, binding = BINDING_ROWS_OUT) writeonly buffer RowsOut { int rows_out[]; };
layout(std430, binding = BINDING_ROWS_OUT_1) writeonly buffer RowsOut1 { int rows_out_1[]; };
layout(std430, binding = BINDING_ROWS_OUT_2) writeonly buffer RowsOut2 { int rows_out_2[]; };
layout(std430, binding = BINDING_ROWS_OUT_3) writeonly buffer RowsOut3 { int rows_out_3[]; };
#ifdef SHIFTS
layout(std430, binding = BINDING_IMAGE_HOME) readonly buffer ImageHome { uint image_home[]; };
layout(std430, binding = BINDING_SHIFTS_OUT) writeonly buffer ShiftsOut { uint shifts_out[]; };
layout(std430, binding = BINDING_SHIFTS_OUT_1) writeonly buffer ShiftsOut1 { uint shifts_out_1[]; };
layout(std430, binding = BINDING_SHIFTS_OUT_2) writeonly buffer ShiftsOut2 { uint shifts_out_2[]; };
layout(std430, binding = BINDING_SHIFTS_OUT_3) writeonly buffer ShiftsOut3 { uint shifts_out_3[]; };
#endif
#ifdef AREAS
layout(std430, binding = BINDING_AREAS) readonly buffer Areas { uvec2 areas[]; };
layout(std430, binding = BINDING_SECOND_AREAS) readonly buffer SecondAreas { uvec2 second_areas[]; };
layout(std430, binding = BINDING_AREAS_OUT) writeonly buffer AreasOut { uvec2 areas_out[]; };
#endif

int entry(uint place, uint i) {
    const uint column = place & ~SECOND_TIER_BIT;
    return (place & SECOND_TIER_BIT) != 0u ? second_rows[i * push.second_row_stride + column]
                                           : rows[i * push.row_stride + column];
}

#ifdef SHIFTS
// A neighbor: its seed, and by which shift.
ivec2 named(int id) {
    if (id < int(push.own_count)) return ivec2(id, SHIFT_NONE);
    const uint home = image_home[uint(id) - push.own_count];
    return ivec2(int(home >> SHIFT_BITS), int(home & ((1u << SHIFT_BITS) - 1u)));
}
bool before(ivec2 a, ivec2 b) {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

void put_shift(uint place, int code) {
    const uvec3 shift = uvec3(code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1) & 0xffu;
    const uint packed = shift.x | (shift.y << 8) | (shift.z << 16);
    const uint window = place >> push.window_bits, at = place & ((1u << push.window_bits) - 1u);
    if (window == 0u)
        shifts_out[at] = packed;
    else if (window == 1u)
        shifts_out_1[at] = packed;
    else if (window == 2u)
        shifts_out_2[at] = packed;
    else
        shifts_out_3[at] = packed;
}
#endif

void put(uint place, int id) {
    const uint window = place >> push.window_bits, at = place & ((1u << push.window_bits) - 1u);
    if (window == 0u)
        rows_out[at] = id;
    else if (window == 1u)
        rows_out_1[at] = id;
    else if (window == 2u)
        rows_out_2[at] = id;
    else
        rows_out_3[at] = id;
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
#ifdef SHIFTS
        const ivec2 mine = named(id);
        for (uint j = 0u; j < length; ++j)
            if (before(named(entry(place, j)), mine)) ++rank;
        put(offset + rank, mine.x);
        put_shift(offset + rank, mine.y);
#else
        for (uint j = 0u; j < length; ++j)
            if (entry(place, j) < id) ++rank;
        put(offset + rank, id);
#endif
#ifdef AREAS
        const uint column = place & ~SECOND_TIER_BIT;
        if ((place & SECOND_TIER_BIT) != 0u)
            areas_out[offset + rank] = second_areas[i * push.second_row_stride + column];
        else
            areas_out[offset + rank] = areas[i * push.row_stride + column];
#endif
    }
}

// download: packs the rows of a chunk one after the other, each in ascending order.
//
// Variants: AREAS packs areas too, in one window; a Number of either kind moves as two words. NAMES replaces ids by
// their names and packs shifts too; rows are in the order of both. FRAME, with AREAS, converts areas to float32, in
// units of length as given; GEOMETRY_FLOAT64 as in download_cells.comp.
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
#ifndef AREAS
layout(std430, binding = BINDING_ROWS_OUT_1) writeonly buffer RowsOut1 { int rows_out_1[]; };
layout(std430, binding = BINDING_ROWS_OUT_2) writeonly buffer RowsOut2 { int rows_out_2[]; };
layout(std430, binding = BINDING_ROWS_OUT_3) writeonly buffer RowsOut3 { int rows_out_3[]; };
#endif
#ifdef NAMES
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_NAMES) readonly buffer Names { uvec2 names[]; };
layout(std430, binding = BINDING_SHIFTS_OUT) writeonly buffer ShiftsOut { uint shifts_out[]; };
#ifndef AREAS
layout(std430, binding = BINDING_SHIFTS_OUT_1) writeonly buffer ShiftsOut1 { uint shifts_out_1[]; };
layout(std430, binding = BINDING_SHIFTS_OUT_2) writeonly buffer ShiftsOut2 { uint shifts_out_2[]; };
layout(std430, binding = BINDING_SHIFTS_OUT_3) writeonly buffer ShiftsOut3 { uint shifts_out_3[]; };
#endif
#endif
#ifdef AREAS
#ifdef FRAME
#include "numbers/number.glsl"
layout(std430, binding = BINDING_INFO) readonly buffer Info { uint info[]; };
#define AREA_IN Number
#define AREA_OUT float
#else
#define AREA_IN uvec2
#define AREA_OUT uvec2
#endif
layout(std430, binding = BINDING_AREAS) readonly buffer Areas { AREA_IN areas[]; };
layout(std430, binding = BINDING_SECOND_AREAS) readonly buffer SecondAreas { AREA_IN second_areas[]; };
layout(std430, binding = BINDING_AREAS_OUT) writeonly buffer AreasOut { AREA_OUT areas_out[]; };

// In two steps: devices may flush a power of two below float32's range.
AREA_OUT area_out(AREA_IN area, uint cell) {
#ifdef FRAME
    const int exponent = int(info[cell] >> INFO_EXPONENT_SHIFT) - push.shift;
    return ldexp(ldexp(rounded(area), exponent), exponent);
#else
    return area;
#endif
}
#endif

int entry(uint place, uint i) {
    const uint column = place & ~SECOND_TIER_BIT;
    return (place & SECOND_TIER_BIT) != 0u ? second_rows[i * push.second_row_stride + column]
                                           : rows[i * push.row_stride + column];
}

#ifdef NAMES
// A neighbor: its seed or a wall, and its shift.
struct Name {
    int id;
    uint shift;
};
Name named(int id) {
    if (id < 0 || uint(id) < push.named_from) return Name(id, SHIFT_NONE);
    const uvec2 name = names[uint(id) - push.named_from];
    return Name(int(name.x), name.y);
}
bool before(Name a, Name b) {
    return a.id < b.id || (a.id == b.id && a.shift < b.shift);
}

void put_shift(uint place, uint shift, uint from) {
    const uvec3 bytes = (uvec3(shift >> 16, shift >> 8, shift) - uvec3(from >> 16, from >> 8, from)) & 0xffu;
    const uint packed = bytes.x | (bytes.y << 8) | (bytes.z << 16);
#ifdef AREAS
    shifts_out[place] = packed;
#else
    const uint window = place >> push.window_bits, at = place & ((1u << push.window_bits) - 1u);
    if (window == 0u)
        shifts_out[at] = packed;
    else if (window == 1u)
        shifts_out_1[at] = packed;
    else if (window == 2u)
        shifts_out_2[at] = packed;
    else
        shifts_out_3[at] = packed;
#endif
}
#endif

void put(uint place, int id) {
#ifdef AREAS
    rows_out[place] = id;
#else
    const uint window = place >> push.window_bits, at = place & ((1u << push.window_bits) - 1u);
    if (window == 0u)
        rows_out[at] = id;
    else if (window == 1u)
        rows_out_1[at] = id;
    else if (window == 2u)
        rows_out_2[at] = id;
    else
        rows_out_3[at] = id;
#endif
}

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.cell_count) return;
    const uint length = row_length[cell], place = row_place[cell];
    if (!row_fits(chunk.row_base, row_offsets[cell], length, push.capacity)) return;
    const uint offset = chunk.row_base + row_offsets[cell];
#ifdef NAMES
    const uint own = named(int(seed_input[push.first_cell + cell] & INDEX_MASK)).shift;
#endif
    for (uint i = 0u; i < length; ++i) {
        const int id = entry(place, i);
        uint rank = 0u;
#ifdef NAMES
        const Name mine = named(id);
        for (uint j = 0u; j < length; ++j)
            if (before(named(entry(place, j)), mine)) ++rank;
        put(offset + rank, mine.id);
        if (push.shifts != 0u) put_shift(offset + rank, mine.id < 0 ? own : mine.shift, own);
#else
        for (uint j = 0u; j < length; ++j)
            if (entry(place, j) < id) ++rank;
        put(offset + rank, id);
#endif
#ifdef AREAS
        const uint column = place & ~SECOND_TIER_BIT;
        if ((place & SECOND_TIER_BIT) != 0u)
            areas_out[offset + rank] = area_out(second_areas[i * push.second_row_stride + column], cell);
        else
            areas_out[offset + rank] = area_out(areas[i * push.row_stride + column], cell);
#endif
    }
}

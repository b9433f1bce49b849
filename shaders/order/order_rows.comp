// order: copies the row of each cell of a frame to its offset. Rows have gaps between them before.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/order.h"

layout(push_constant) uniform Push { OrderPush push; };
layout(std430, binding = BINDING_CELLS) readonly buffer Cells { FrameCell cells[]; };
layout(std430, binding = BINDING_PART_OFFSETS) readonly buffer PartOffsets { uint part_offsets[]; };
layout(std430, binding = BINDING_ROWS_OUT) readonly buffer RowsOut { int rows_out[]; };
layout(std430, binding = BINDING_AREAS_OUT) readonly buffer AreasOut { uint areas_out[]; };
layout(std430, binding = BINDING_SHIFTS_OUT) readonly buffer ShiftsOut { uint shifts_out[]; };
layout(std430, binding = BINDING_SLICE_ROWS) writeonly buffer SliceRows { int slice_rows[]; };
layout(std430, binding = BINDING_SLICE_AREAS) writeonly buffer SliceAreas { uint slice_areas[]; };
layout(std430, binding = BINDING_SLICE_SHIFTS) writeonly buffer SliceShifts { uint slice_shifts[]; };

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.count) return;
    const uint from = cells[cell].row_begin, length = cells[cell].row_length, to = part_offsets[cell];
    for (uint i = 0u; i < length; ++i) {
        slice_rows[to + i] = rows_out[from + i];
        if (push.areas != 0u) slice_areas[to + i] = areas_out[from + i];
        if (push.shifts != 0u) slice_shifts[to + i] = shifts_out[from + i];
    }
}

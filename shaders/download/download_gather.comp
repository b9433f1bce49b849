// download: gathers the rows of consecutive members from the rows out, which are in the order of the chunks. The host
// reads the output, so neighboring invocations write neighboring words.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { GatherPush push; };
layout(std430, binding = BINDING_PART_OFFSETS) readonly buffer PartOffsets { uint part_offsets[]; };
layout(std430, binding = BINDING_PART_BEGIN) readonly buffer PartBegin { uint part_begin[]; };
layout(std430, binding = BINDING_ROWS_OUT) readonly buffer RowsOut { int rows_out[]; };
layout(std430, binding = BINDING_SHIFTS_OUT) readonly buffer ShiftsOut { uint shifts_out[]; };
layout(std430, binding = BINDING_AREAS_OUT) readonly buffer AreasOut { uvec2 areas_out[]; };
layout(std430, binding = BINDING_SLICE_ROWS) writeonly buffer SliceRows { ivec4 slice_rows[]; };
layout(std430, binding = BINDING_SLICE_AREAS) writeonly buffer SliceAreas { uvec4 slice_areas[]; };
layout(std430, binding = BINDING_SLICE_SHIFTS) writeonly buffer SliceShifts { uint slice_shifts[]; };

void main() {
    const uint quad = linear_invocation(), first = GATHER_ENTRIES * quad;
    if (first >= push.entry_count) return;
    // The last cell that does not begin behind the first entry: the entry is in its row.
    uint low = push.first_cell, high = push.first_cell + push.cell_count - 1u;
    while (low < high) {
        const uint middle = low + (high - low + 1u) / 2u;
        if (part_offsets[middle] <= push.first_entry + first)
            low = middle;
        else
            high = middle - 1u;
    }
    uint places[GATHER_ENTRIES];
    for (uint i = 0u; i < GATHER_ENTRIES; ++i) {
        const uint entry = push.first_entry + min(first + i, push.entry_count - 1u);
        while (low + 1u < push.first_cell + push.cell_count && part_offsets[low + 1u] <= entry) ++low;
        places[i] = part_begin[low] + (entry - part_offsets[low]);
    }
    slice_rows[quad] = ivec4(rows_out[places[0]], rows_out[places[1]], rows_out[places[2]], rows_out[places[3]]);
    if (push.areas != 0u) {
        slice_areas[2u * quad] = uvec4(areas_out[places[0]], areas_out[places[1]]);
        slice_areas[2u * quad + 1u] = uvec4(areas_out[places[2]], areas_out[places[3]]);
    }
    if (push.shifts != 0u) {
        const uvec4 s = uvec4(shifts_out[places[0]], shifts_out[places[1]], shifts_out[places[2]], shifts_out[places[3]]);
        slice_shifts[3u * quad] = s.x | (s.y << 24);
        slice_shifts[3u * quad + 1u] = (s.y >> 8) | (s.z << 16);
        slice_shifts[3u * quad + 2u] = (s.z >> 16) | (s.w << 8);
    }
}

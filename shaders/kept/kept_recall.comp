// kept: puts the stored cells of the last frame into the columns of this one, and makes all cells pending. A cell whose
// neighbors are not there stays without a column.
//
// Variant: NAMES finds images by their seeds and shifts.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { KeptPush push; };
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_PLACES) readonly buffer Places { uint places[]; };
layout(std430, binding = BINDING_KEPT) readonly buffer Kept { uint kept[]; };
layout(std430, binding = BINDING_ROWS) writeonly buffer Rows { int rows[]; };

#ifdef NAMES
layout(std430, binding = BINDING_NAMES) readonly buffer NameList { uvec2 names[]; };
layout(std430, binding = BINDING_SCAN_DATA) readonly buffer Offsets { uint offsets[]; };
#endif

#include "kept/kept_column.glsl"
#include "shared/chunk.glsl"

// Returns the sorted seed of a point or of its image, or a negative number.
int seed_of(uint point, uint shift) {
    if (point >= push.own_count) return -1;
#ifdef NAMES
    if (shift != SHIFT_NONE) {
        for (uint i = offsets[point]; i < push.image_count && names[i].x == point; ++i)
            if (names[i].y == shift) return int(places[push.own_count + i]);
        return -1;
    }
#endif
    return int(places[point]);
}

uint read_cell(uint cell, uint seed) {
    const uint head = kept[seed], planes = kept_planes(head), corners = kept_corners(head);
    if (planes == 0u || planes > KEPT_PLANES || corners > KEPT_CORNERS) return 0u;
    for (uint i = 0u; i < planes; ++i) {
        const uint at = (1u + i) * push.capacity + seed;
        int id = int(kept[at]);
        if (id >= 0) {
#ifdef NAMES
            id = seed_of(uint(id), kept[(KEPT_STORED_WORDS + i) * push.capacity + seed]);
#else
            id = seed_of(uint(id), SHIFT_NONE);
#endif
            if (id < 0) return 0u;
        }
        rows[plane_place(cell, i)] = id;
    }
    for (uint v = 0u; v < corners; v += 2u) {
        const uint two = kept[(1u + KEPT_PLANES + v / 2u) * push.capacity + seed];
        for (uint k = 0u; k < 2u; ++k) {
            const uint corner = (two >> (16u * k)) & 0xffffu;
            rows[corner_place(cell, v + k)] =
                int((corner & 31u) | (((corner >> 5) & 31u) << 8) | (((corner >> 10) & 31u) << 16));
        }
    }
    return KEPT_MADE | planes | (corners << KEPT_CORNERS_SHIFT);
}

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.cell_count) return;
    const uint seed = seed_input[cell];  // of a duplicate it is larger than all numbers
    of_cells[word_at(WORDS_INFO, cell)] = STATUS_CANDIDATES_EXHAUSTED;
    of_cells[word_at(WORDS_ROW_LENGTH, cell)] = 0u;
    of_cells[word_at(WORDS_KEPT, cell)] = seed < push.own_count ? read_cell(cell, seed) : 0u;
}

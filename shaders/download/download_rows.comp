// download: packs the rows of a chunk one after the other, each in ascending order. A dispatch writes those entries that are
// in its window.
//
// Variants: AREAS packs areas too; a Number of either kind moves as two words. NAMES replaces ids by
// their names and packs shifts too; rows are in the order of both. FRAME, with AREAS, converts areas to float32, in
// units of length as given; GEOMETRY_FLOAT64 as in download_cells.comp.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "download/row_fits.glsl"
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { RowsPush push; };
layout(std430, binding = BINDING_ROWS) readonly buffer Rows { int rows[]; };
layout(std430, binding = BINDING_ROWS_OUT) writeonly buffer RowsOut { int rows_out[]; };
#ifdef NAMES
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_NAMES) readonly buffer Names { uvec2 names[]; };
layout(std430, binding = BINDING_SHIFTS_OUT) writeonly buffer ShiftsOut { uint shifts_out[]; };
#endif

#include "shared/chunk.glsl"

#ifdef AREAS
#ifdef FRAME
#include "numbers/number.glsl"
#define AREA_IN Number
#define AREA_OUT float
#else
#define AREA_IN uvec2
#define AREA_OUT uvec2
#endif
layout(std430, binding = BINDING_AREAS) readonly buffer Areas { AREA_IN areas[]; };
layout(std430, binding = BINDING_AREAS_OUT) writeonly buffer AreasOut { AREA_OUT areas_out[]; };

// In two steps: devices may flush a power of two below float32's range.
AREA_OUT area_out(AREA_IN area, uint cell) {
#ifdef FRAME
    const int exponent = int(word_of(WORDS_INFO, cell) >> INFO_EXPONENT_SHIFT) - push.shift;
    return ldexp(ldexp(rounded(area), exponent), exponent);
#else
    return area;
#endif
}
#endif

// Returns where in the rows, and in the areas, face i of a cell is.
uint place_of_face(uint place, uint i) {
    const uint column = place & ~SECOND_TIER_BIT;
    return (place & SECOND_TIER_BIT) != 0u ? push.second_first + i * push.second_row_stride + column
                                           : i * push.row_stride + column;
}

int entry(uint place, uint i) {
    return rows[place_of_face(place, i)];
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

// Returns the difference of two shifts as int8 x y z 0.
uint relative_shift(uint shift, uint from) {
    const uvec3 bytes = (uvec3(shift >> 16, shift >> 8, shift) - uvec3(from >> 16, from >> 8, from)) & 0xffu;
    return bytes.x | (bytes.y << 8) | (bytes.z << 16);
}
#endif

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.cell_count) return;
    const uint length = word_of(WORDS_ROW_LENGTH, cell), place = word_of(WORDS_ROW_PLACE, cell),
               offset = word_of(WORDS_ROW_OFFSET, cell);
    if (length == 0u || !row_fits(chunk.row_base, offset, length, push.capacity)) return;
    const uint begin = chunk.row_base + offset, last_entry = begin + length - 1u;
    if (begin >> push.window_bits > push.window || last_entry >> push.window_bits < push.window) return;
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
#else
        for (uint j = 0u; j < length; ++j)
            if (entry(place, j) < id) ++rank;
#endif
        const uint to = begin + rank, at = to & ((1u << push.window_bits) - 1u);
        if (to >> push.window_bits != push.window) continue;
#ifdef NAMES
        rows_out[at] = mine.id;
        if (push.shifts != 0u) shifts_out[at] = relative_shift(mine.id < 0 ? own : mine.shift, own);
#else
        rows_out[at] = id;
#endif
#ifdef AREAS
        areas_out[at] = area_out(areas[place_of_face(place, i)], cell);
#endif
    }
}

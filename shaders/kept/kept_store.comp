// kept: stores the cells that were made, for the next frame. Kept ones are stored already.
//
// Variant: NAMES, where there are images.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { KeptPush push; };
layout(std430, binding = BINDING_PLACES) readonly buffer Places { uint places[]; };
layout(std430, binding = BINDING_KEPT) writeonly buffer Kept { uint kept[]; };
layout(std430, binding = BINDING_ROWS) readonly buffer Rows { int rows[]; };

#include "kept/kept_column.glsl"
#include "kept/kept_name.glsl"
#include "shared/chunk.glsl"

uint packed_corner(uint cell, uint corner) {
    const uint planes = uint(rows[corner_place(cell, corner)]);
    return (planes & 31u) | (((planes >> 8) & 31u) << 5) | (((planes >> 16) & 31u) << 10);
}

void main() {
    const uint seed = linear_invocation();
    if (seed >= push.capacity) return;
    uint cell = 0u, word = 0u;
    if (seed < push.own_count) {
        cell = places[seed];
        word = word_of(WORDS_KEPT, cell);
    }
    if ((word & KEPT_HELD) != 0u) return;
    if ((word & KEPT_MADE) == 0u) {
        kept[seed] = 0u;
        return;
    }
    const uint planes = kept_planes(word), corners = kept_corners(word);
    kept[seed] = planes | (corners << KEPT_CORNERS_SHIFT);
    for (uint i = 0u; i < planes; ++i) {
        const Name name = name_of(rows[plane_place(cell, i)]);
        kept[(1u + i) * push.capacity + seed] = uint(name.id);
#ifdef NAMES
        kept[(KEPT_STORED_WORDS + i) * push.capacity + seed] = name.shift ^ SHIFT_NONE;
#endif
    }
    for (uint v = 0u; v < corners; v += 2u)
        kept[(1u + KEPT_PLANES + v / 2u) * push.capacity + seed] =
            packed_corner(cell, v) | (packed_corner(cell, v + 1u) << 16);
}

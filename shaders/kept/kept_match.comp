// kept: compares the kept cells with their neighbors that were made. Where both have not the same face, with the same
// corners, the kept cell becomes pending. Kept cells match each other, as in the last frame. Also lists the unknown
// cells, which have no column, and chooses a kept cell for kept_cover.
//
// Variant: NAMES, where there are images.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "invocations/loop_guard.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { KeptPush push; };
layout(std430, binding = BINDING_PLACES) readonly buffer Places { uint places[]; };
layout(std430, binding = BINDING_ROWS) readonly buffer Rows { int rows[]; };

#include "kept/kept_column.glsl"
#include "kept/kept_name.glsl"
#include "shared/chunk.glsl"

void drop(uint cell) {
    of_cells[word_at(WORDS_KEPT, cell)] = 0u;
    of_cells[word_at(WORDS_INFO, cell)] = STATUS_CANDIDATES_EXHAUSTED;
    chunk.kept_pending = 1u;
}

Name plane_name(uint cell, uint plane) {
    return name_of(rows[plane_place(cell, plane)]);
}

// Returns the plane with a name, or KEPT_PLANES.
uint find_plane(uint cell, uint planes, Name name) {
    for (uint i = 0u; i < planes; ++i)
        if (plane_name(cell, i) == name) return i;
    return KEPT_PLANES;
}

// Returns the two other planes of a corner on this plane. on: whether it is.
uvec2 others_of(uint cell, uint corner, uint plane, out bool on) {
    const uint packed = uint(rows[corner_place(cell, corner)]);
    const uvec3 of = uvec3(packed, packed >> 8, packed >> 16) & 0xffu;
    on = of.x == plane || of.y == plane || of.z == plane;
    return of.x == plane ? of.yz : (of.y == plane ? of.xz : of.xy);
}

// Returns whether a face of a kept cell is a face of the neighbor across it, with the same corners.
bool is_face_of(uint cell, uint word, uint plane, uint other, uint other_word, Name own, Name name) {
    const Name back = seen_from(own, name.shift);
    const uint face = find_plane(other, kept_planes(other_word), back);
    if (face == KEPT_PLANES) return false;
    uint expected = 0u, found = 0u;
    for (uint w = 0u; w < kept_corners(other_word); ++w) {
        bool on;
        others_of(other, w, face, on);
        if (on) ++expected;
    }
    for (uint v = 0u; v < kept_corners(word); ++v) {
        bool on;
        const uvec2 mine = others_of(cell, v, plane, on);
        if (!on) continue;
        const Name a = seen_from(plane_name(cell, mine.x), name.shift), b = seen_from(plane_name(cell, mine.y), name.shift);
        bool same = false;
        for (uint w = 0u; w < kept_corners(other_word) && !same; ++w) {
            bool on_face;
            const uvec2 theirs = others_of(other, w, face, on_face);
            if (!on_face) continue;
            const Name c = plane_name(other, theirs.x), d = plane_name(other, theirs.y);
            same = (a == c && b == d) || (a == d && b == c);
        }
        if (!same) return false;
        ++found;
    }
    return found == expected;
}

bool matches(uint cell, uint word, Name own) {
    for (uint i = 0u; i < kept_planes(word); ++i) {
        const Name name = plane_name(cell, i);
        if (name.id < 0) continue;
        const uint other = places[name.id], other_word = word_of(WORDS_KEPT, other);
        if ((other_word & KEPT_HELD) != 0u || other_word == 0u) continue;  // the next round compares with pending ones
        if ((other_word & KEPT_MADE) == 0u || !is_face_of(cell, word, i, other, other_word, own, name)) return false;
    }
    return true;
}

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.cell_count) return;
    const uint seed = seed_input[cell];
    if (seed >= push.own_count) return;
    const uint word = word_of(WORDS_KEPT, cell);
    const Name own = Name(int(seed), 0u);
    if ((word & KEPT_HELD) != 0u) {
        if (!matches(cell, word, own))
            drop(cell);
        else if (cell < chunk.kept_point)
            atomicMin(chunk.kept_point, cell);
    } else if ((word & KEPT_MADE) != 0u) {
        for (uint i = 0u; i < kept_planes(word); ++i) {
            const Name name = plane_name(cell, i);
            if (name.id < 0) continue;
            const uint other = places[name.id], other_word = word_of(WORDS_KEPT, other);
            if ((other_word & KEPT_HELD) != 0u &&
                find_plane(other, kept_planes(other_word), seen_from(own, name.shift)) == KEPT_PLANES)
                drop(other);
        }
    } else {
        const uint status = word_of(WORDS_INFO, cell) & 0xffu;
        if (status != STATUS_EMPTY && status != STATUS_OUTSIDE && status != STATUS_DUPLICATE) {
            const uint i = atomicAdd(chunk.unknown_count, 1u);
            if (i < KEPT_UNKNOWN) chunk.unknown[i] = cell;
        }
    }
    if (loops_were_cut_short(2u + (push.cell_count >> 31))) chunk.kept_pending = 1u;
}

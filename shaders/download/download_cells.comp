// download: writes the cells of a frame, in input order, and its counts.
//
// Variant: GEOMETRY_FLOAT64 reads geometry of a pass of that variant.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "download/row_fits.glsl"
#include "invocations/index.glsl"
#include "numbers/number.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { FramePush push; };
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_GEOMETRY) readonly buffer Geometry { Number geometry[]; };
layout(std430, binding = BINDING_HEADER) buffer Header { FrameHeader header; };
layout(std430, binding = BINDING_CELLS) writeonly buffer Cells { FrameCell cells[]; };
layout(std430, binding = BINDING_GEOMETRY_OUT) writeonly buffer GeometryOut { vec4 geometry_out[]; };

#include "search/seeds.glsl"
#include "shared/chunk.glsl"

// The work-group counts its own cells and adds them to the header at once.
shared uint certified, unresolved, duplicates, empty, outside, faces_of_all, kept;

void main() {
    const bool leads = gl_LocalInvocationIndex == 0u;
    if (leads) certified = unresolved = duplicates = empty = outside = faces_of_all = kept = 0u;
    barrier();
    const uint cell = linear_invocation();
    const uint seed = cell < push.cell_count ? seed_input[push.first_cell + cell] & INDEX_MASK : push.own_count;
    if (seed < push.own_count) {
        const uint word = word_of(WORDS_INFO, cell);
        uint status = word & 0xffu, begin = 0u, length = 0u;
        if (status == STATUS_DUPLICATE && seed_y(push.first_cell + cell).y != NO_COORDINATE) status = STATUS_EMPTY;
        if (push.neighbors != 0u && status == STATUS_CERTIFIED) {
            const uint offset = word_of(WORDS_ROW_OFFSET, cell);
            length = word_of(WORDS_ROW_LENGTH, cell);
            begin = chunk.row_base + offset;
            if (!row_fits(chunk.row_base, offset, length, push.capacity)) {
                status = STATUS_CANDIDATES_EXHAUSTED;
                begin = length = 0u;
            }
        }
        const bool done = status == STATUS_CERTIFIED;
        const uint faces = done ? (word >> INFO_FACES_SHIFT) & 0xffu : 0u;
        cells[seed] = FrameCell(status, begin, length, faces);
        if (push.geometry != 0u) {
            const int exponent = int(word >> INFO_EXPONENT_SHIFT) - push.shift;
            vec4 g = vec4(0);
            if (done)
                g = vec4(rounded(geometry[4u * cell + 1u]), rounded(geometry[4u * cell + 2u]),
                         rounded(geometry[4u * cell + 3u]), rounded(geometry[4u * cell]));
            // The volume is scaled in steps: devices may flush a power of two below float32's range.
            g.w = ldexp(ldexp(g.w, exponent), exponent);
            geometry_out[seed] = ldexp(g, ivec4(exponent));
        }
        if (done) {
            atomicAdd(certified, 1u);
            atomicAdd(faces_of_all, faces);
            if (push.keeps != 0u && (word_of(WORDS_KEPT, cell) & KEPT_HELD) != 0u) atomicAdd(kept, 1u);
        } else if (status == STATUS_DUPLICATE) {
            atomicAdd(duplicates, 1u);
        } else if (status == STATUS_EMPTY) {
            atomicAdd(empty, 1u);
        } else if (status == STATUS_OUTSIDE) {
            if (seed < header.seeds) atomicAdd(outside, 1u);
        } else {
            atomicAdd(unresolved, 1u);
        }
    }
    barrier();
    if (!leads) return;
    if (certified > 0u) atomicAdd(header.certified, certified);
    if (unresolved > 0u) atomicAdd(header.unresolved, unresolved);
    if (duplicates > 0u) atomicAdd(header.duplicates, duplicates);
    if (empty > 0u) atomicAdd(header.empty, empty);
    if (outside > 0u) atomicAdd(header.outside, outside);
    if (faces_of_all > 0u) atomicAdd(header.faces, faces_of_all);
    if (kept > 0u) atomicAdd(header.kept, kept);
}

// The buffers of the run that both kernels read, and those of cells that they write. The .comp declares `push`, with
// cell_count, before.
#ifndef VOTESS_CLIP_CELL_RESULTS_GLSL
#define VOTESS_CLIP_CELL_RESULTS_GLSL

#include "numbers/number.glsl"
#include "shared/chunk.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(constant_id = CONSTANT_GEOMETRY) const uint want_geometry = 1u;
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
#ifdef READS_ROWS
layout(std430, binding = BINDING_ROWS) buffer Rows { int rows[]; };
#else
layout(std430, binding = BINDING_ROWS) writeonly buffer Rows { int rows[]; };
#endif
layout(std430, binding = BINDING_GEOMETRY) writeonly buffer Geometry { uvec2 geometry[]; };
layout(std430, binding = BINDING_AREAS) writeonly buffer Areas { uvec2 areas[]; };

void put_cell(uint cell, uint info, uint length, uint place) {
    of_cells[word_at(WORDS_INFO, cell)] = info;
    of_cells[word_at(WORDS_ROW_LENGTH, cell)] = length;
    of_cells[word_at(WORDS_ROW_PLACE, cell)] = place;
}

// Returns a measure in the format that all cells of a run have.
#ifdef CLIP_FLOAT64
layout(constant_id = CONSTANT_WRITES_SUMS) const uint writes_sums = 0u;

uvec2 written(Number a) {
    if (writes_sums == 0u) return words_of(a);
    const float high = float(a);
    return floatBitsToUint(vec2(high, float(a - Number(high))));
}
#else
uvec2 written(Number a) {
    return words_of(a);
}
#endif

#endif

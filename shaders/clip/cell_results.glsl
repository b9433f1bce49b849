// The buffers of the run that both kernels read, and those of cells that they write.
#ifndef VOTESS_CLIP_CELL_RESULTS_GLSL
#define VOTESS_CLIP_CELL_RESULTS_GLSL

#include "numbers/number.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(constant_id = CONSTANT_GEOMETRY) const uint want_geometry = 1u;
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_INFO) buffer Info { uint info[]; };
layout(std430, binding = BINDING_ROW_LENGTH) writeonly buffer RowLength { uint row_length[]; };
layout(std430, binding = BINDING_ROW_PLACE) writeonly buffer RowPlace { uint row_place[]; };
layout(std430, binding = BINDING_ROWS) writeonly buffer Rows { int rows[]; };
layout(std430, binding = BINDING_GEOMETRY) writeonly buffer Geometry { uvec2 geometry[]; };
layout(std430, binding = BINDING_AREAS) writeonly buffer Areas { uvec2 areas[]; };

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

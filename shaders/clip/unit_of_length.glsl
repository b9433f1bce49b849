// The cell's unit of length, and the numbers that depend on it.
#ifndef VOTESS_CLIP_UNIT_OF_LENGTH_GLSL
#define VOTESS_CLIP_UNIT_OF_LENGTH_GLSL

#include "clip/cell_results.glsl"
#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "clip/walls.glsl"
#include "search/seed_weights.glsl"

// Sets the unit to 2^exponent units of coordinates. root: the node of the root of the hierarchy.
void set_unit_of_length(uint exponent, uint root) {
    scale = uintBitsToFloat((127u - exponent) << 23);
    quantum = real(quantum_in_units(state.lossy) * scale);
    if (weighted == 0u) return;
    weight_scale = scale * scale * uintBitsToFloat(uint(127 + state.weight_exponent) << 23);
    weight_quantum = state.lossy_weights != 0u ? real(weight_scale) : real(0);
    quantum += real(0.6) * weight_quantum;
    max_heavier = max(heavier_by(lighter_by(node_weights[root])), real(0));
}

#endif

// The cell's unit of length, and the numbers that depend on it.
#ifndef VOTESS_CLIP_UNIT_OF_LENGTH_GLSL
#define VOTESS_CLIP_UNIT_OF_LENGTH_GLSL

#include "clip/cell_results.glsl"
#include "clip/filter.glsl"
#include "clip/relative_to_seed.glsl"
#include "clip/walls.glsl"
#include "search/nodes.glsl"

// Sets the unit to 2^exponent units of coordinates. root: the node of the root of the hierarchy.
void set_unit_of_length(uint exponent, uint root) {
    scale = uintBitsToFloat((127u - exponent) << 23);
    quantum = real(quantum_in_units(state.lossy) * scale);
    if (weighted == 0u) return;
    weight_bits = uint(state.weight_exponent);
    weight_scale = scale * scale * uintBitsToFloat((127u + weight_bits) << 23);
    weight_quantum = state.lossy_weights != 0u ? real(weight_scale) : real(0);
    tilt_length = real(length(vec3(tilt)) * 1.00001 * exp2(float(TILT_BITS)) * scale);
    quantum = (quantum + real(0.6) * weight_quantum) * (real(1) + tilt_length);
    max_heavier = max(heavier_by(lighter_by(max64(weights_at(root).largest, state.heaviest))), real(0));
}

#endif

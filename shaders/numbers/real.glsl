// The numbers that a cell is clipped in, and their unit roundoff. Variant: CLIP_FLOAT64.
//
// `precise` makes each sum and product, of float64 too, an operation of its own, with its own rounding (NoContraction).
// SPIR-V has no such promise for fma(): a device may fuse it, or round the product and then the sum. Error bounds count
// both roundings, so that they hold either way. What needs every rounding as it is written, exact sums and products,
// uses no fma (numbers/number.glsl). The host demands to round to nearest where the device offers it
// (engine/gpu/vulkan/spirv.hpp), and tries out how all of them round (probe_rounding.comp).
#ifndef VOTESS_NUMBERS_REAL_GLSL
#define VOTESS_NUMBERS_REAL_GLSL

#include "shared/interface.h"

// Every variant declares it, so that the host need not know which one it has.
layout(constant_id = CONSTANT_UNIT_ROUNDOFF) const float float_unit = 5.9604645e-8;

#ifdef CLIP_FLOAT64
#define real double
#define real2 dvec2
#define real4 dvec4
const double unit = 1.1102230246251565e-16LF;

// Whether a number is from 0 on and less than this.
bool is_positive_below(double number, double end) {
    return number >= 0.0LF && number < end;
}
#else
#define real float
#define real2 vec2
#define real4 vec4
const float unit = float_unit;

// The same; bits of numbers below 0, or of what is no number, are larger ones.
bool is_positive_below(float number, float end) {
    return floatBitsToUint(number) < floatBitsToUint(end);
}
#endif

#endif

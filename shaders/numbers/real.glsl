// The numbers that clip a cell, and their unit roundoff. Variant: CLIP_FLOAT64.
//
// `precise` makes each sum and product, of float64 too, an operation with its own rounding (NoContraction). SPIR-V
// promises no such thing for fma(): a device may fuse it, or round the product and then the sum. Error bounds count
// both roundings, so they hold either way. Exact sums and products, which need every rounding as written, use no fma
// (numbers/number.glsl). The host demands rounding to nearest where the device offers it (engine/gpu/vulkan/spirv.hpp),
// and tests how each device rounds (probe_rounding.comp).
#ifndef VOTESS_NUMBERS_REAL_GLSL
#define VOTESS_NUMBERS_REAL_GLSL

#include "shared/interface.h"

// Every variant declares it, so the host does not need to know the variant.
layout(constant_id = CONSTANT_UNIT_ROUNDOFF) const float float_unit = 5.9604645e-8;

#ifdef CLIP_FLOAT64
#define real double
const uint words_of_real = 2u;
const double unit = 1.1102230246251565e-16LF;
#else
#define real float
const uint words_of_real = 1u;
const float unit = float_unit;
#endif

#endif

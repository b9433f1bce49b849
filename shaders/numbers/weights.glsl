// Whether seeds have weights. A pass of a power diagram is made with the constant 1; with 0 the compiler drops the
// guarded code.
#ifndef VOTESS_NUMBERS_WEIGHTS_GLSL
#define VOTESS_NUMBERS_WEIGHTS_GLSL

#include "shared/interface.h"

layout(constant_id = CONSTANT_WEIGHTS) const uint weighted = 0u;

#endif

// Whether seeds have weights: a pass of a power diagram is made with the constant 1, and any other does without what it
// guards.
#ifndef VOTESS_NUMBERS_WEIGHTS_GLSL
#define VOTESS_NUMBERS_WEIGHTS_GLSL

#include "shared/interface.h"

layout(constant_id = CONSTANT_WEIGHTS) const uint weighted = 0u;

#endif

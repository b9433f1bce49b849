// The coordinates of the sorted seeds, in units.
#ifndef VOTESS_SEARCH_SEEDS_GLSL
#define VOTESS_SEARCH_SEEDS_GLSL

#include "shared/interface.h"

layout(std430, binding = BINDING_SEEDS_X) readonly buffer SeedsX { uvec2 seeds_x[]; };
layout(std430, binding = BINDING_SEEDS_Y) readonly buffer SeedsY { uvec2 seeds_y[]; };
layout(std430, binding = BINDING_SEEDS_Z) readonly buffer SeedsZ { uvec2 seeds_z[]; };

#endif

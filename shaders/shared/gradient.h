// Push constants of the passes for gradients of a frame's cells. GLSL and C++ include this.
#ifndef VOTESS_SHADERS_GRADIENT_H
#define VOTESS_SHADERS_GRADIENT_H

#include "shared/layout.h"

// GradientPush.bits
#define GRADIENT_SHIFTS 1u      // rows have shifts
#define GRADIENT_WEIGHTS 2u     // points have weights
#define GRADIENT_OF_VOLUMES 4u  // vectors are given for volumes, and so on
#define GRADIENT_OF_CENTROIDS 8u
#define GRADIENT_OF_AREAS 16u
#define GRADIENT_FLOAT64 32u   // outputs are float64
#define GRADIENT_OBLIQUE 64u   // walls have any direction; else they are faces of the box, two an axis
#define GRADIENT_AXES_SHIFT 8  // two bits for each of these axes

#define GRADIENT_UNKNOWN 0x7ffc0000u  // high word of a NaN in float64, of a cell without a gradient
#define GRADIENT_LANES 32             // invocations of a work-group, which makes the numbers of a seed

#ifdef __cplusplus
namespace votess::gpu {
#endif

struct GradientPush {
    uvec2 vector[9];  // along which the domain repeats: a, b, c in units
    uvec2 extent[3];  // of the box in units
    uint count;       // of points
    uint total;       // of points, places of images included
    uint walls;       // number of walls
    uint weights_at;  // where the numbers by weights begin in the gradient
    int shift;        // as in UploadPush
    uint bits;
};

#ifdef __cplusplus
}  // namespace votess::gpu
#endif

#endif

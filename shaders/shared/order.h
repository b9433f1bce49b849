// Push constants of the passes that put the rows of a frame in the order of the seeds. GLSL and C++ include this.
#ifndef VOTESS_SHADERS_ORDER_H
#define VOTESS_SHADERS_ORDER_H

#include "shared/layout.h"

#ifdef __cplusplus
namespace votess::gpu {
#endif

struct OrderPush {
    uint count;      // of cells
    uint neighbors;  // 1: there are rows; and so on
    uint volumes;
    uint centroids;
    uint areas;
    uint shifts;
};

#ifdef __cplusplus
}  // namespace votess::gpu
#endif

#endif

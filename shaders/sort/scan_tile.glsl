// Sums over the invocations of a tile.
#ifndef VOTESS_SORT_SCAN_TILE_GLSL
#define VOTESS_SORT_SCAN_TILE_GLSL

#include "shared/config.h"

shared uint sums_of_tile[TILE_GROUP];  // up to and including each invocation, after scan_tile()

// Returns the sum of `mine` over the invocations before this one. All invocations of the work-group must call it.
uint scan_tile(uint mine) {
    const uint me = gl_LocalInvocationID.x;
    sums_of_tile[me] = mine;
    barrier();
    for (uint step = 1u; step < TILE_GROUP; step <<= 1) {
        const uint before = me >= step ? sums_of_tile[me - step] : 0u;
        barrier();
        sums_of_tile[me] += before;
        barrier();
    }
    return sums_of_tile[me] - mine;
}

#endif

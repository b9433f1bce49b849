// The boxes over groups of sorted seeds, and the walk through them. The .comp declares `push`, with level_first, before.
#ifndef VOTESS_SEARCH_HIERARCHY_GLSL
#define VOTESS_SEARCH_HIERARCHY_GLSL

#include "search/nodes.glsl"

// Returns the number of nodes of a level below the root.
uint nodes_of(uint level) {
    return push.level_first[level + 1u] - push.level_first[level];
}

#include "search/walk.glsl"

#endif

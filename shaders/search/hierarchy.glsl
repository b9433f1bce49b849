// A walk through the boxes over groups of sorted seeds. It needs no stack: the number of a node gives its parent and
// siblings. The .comp declares `push`, with level_first, before.
#ifndef VOTESS_SEARCH_HIERARCHY_GLSL
#define VOTESS_SEARCH_HIERARCHY_GLSL

#include "shared/interface.h"
#include "shared/layout.h"

layout(std430, binding = BINDING_NODES) readonly buffer Nodes { Node nodes[]; };

// Returns the number of nodes of a level below the root.
uint nodes_of(uint level) {
    return push.level_first[level + 1u] - push.level_first[level];
}

struct Walk {
    uint root_level, root;  // the walk stays below this node
    uint level, node;
};

// Moves to the children of the current node.
void descend(inout Walk walk) {
    --walk.level;
    walk.node *= FAN;
}

// Moves to the next node that is not below the current one. Returns false at the end.
bool advance(inout Walk walk) {
    for (;;) {
        if (walk.level == walk.root_level) return false;
        ++walk.node;
        if ((walk.node & (FAN - 1u)) != 0u && walk.node < nodes_of(walk.level)) return true;
        walk.node = (walk.node - 1u) >> FAN_BITS;
        ++walk.level;
    }
}

#endif

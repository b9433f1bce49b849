// A walk through the boxes over groups of sorted seeds. It needs no stack: the number of a node gives its parent and
// siblings. nodes_of() is declared before.
#ifndef VOTESS_SEARCH_WALK_GLSL
#define VOTESS_SEARCH_WALK_GLSL

#include "shared/config.h"

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

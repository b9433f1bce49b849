// Walking the boxes over groups of sorted seeds without a stack: a node's number tells its parent and its siblings.
// Needs push.level_first and push.level_count.

// Nodes of a level below the root.
uint nodes_of(uint level) {
    return push.level_first[level + 1u] - push.level_first[level];
}

struct Walk {
    uint root_level, root;  // the walk stays below this node
    uint level, node;
};

// To the children of the current node.
void descend(inout Walk walk) {
    --walk.level;
    walk.node *= FAN;
}

// To the next node that is not below the current one; false at the end.
bool advance(inout Walk walk) {
    for (;;) {
        if (walk.level == walk.root_level) return false;
        ++walk.node;
        if ((walk.node & (FAN - 1u)) != 0u && walk.node < nodes_of(walk.level)) return true;
        walk.node = (walk.node - 1u) >> FAN_BITS;
        ++walk.level;
    }
}

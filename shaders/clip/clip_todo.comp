// clip: lists the cells that the first tier left, ascending, for the second tier. It runs twice. First it counts the
// cells of each tile of TILE_ITEMS. A scan turns the counts into offsets; then it writes the list, and the arguments of
// the second tier's indirect dispatches. A tile passes on at most max_of_tile cells and leaves the others to the CPU.
// Which ones does not depend on the chunk or on the order of execution.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "clip/finished.glsl"
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { TodoPush push; };
layout(std430, binding = BINDING_SCAN_SUMS) buffer Tiles { uint tile_begin[]; };

#include "shared/chunk.glsl"

shared uint sums[TILE_GROUP];

bool is_left(uint cell) {
    if (cell >= push.cell_count || is_finished(word_of(WORDS_INFO, cell))) return false;
    return push.keeps == 0u || (word_of(WORDS_KEPT, cell) & KEPT_TRIED_AGAIN) == 0u;
}

void main() {
    const uint tile = linear_group(), tiles = (push.cell_count + TILE_ITEMS - 1u) / TILE_ITEMS;
    const uint me = gl_LocalInvocationID.x;
    const uint first = tile * TILE_ITEMS + me * TILE_ITEMS_EACH;
    uint mine = 0u;
    for (uint i = 0u; i < TILE_ITEMS_EACH; ++i) mine += is_left(first + i) ? 1u : 0u;
    sums[me] = mine;
    barrier();
    for (uint step = 1u; step < TILE_GROUP; step <<= 1) {
        const uint before = me >= step ? sums[me - step] : 0u;
        barrier();
        sums[me] += before;
        barrier();
    }
    if (tile >= tiles) return;
    const uint all = sums[TILE_GROUP - 1u], taken = min(all, push.max_of_tile);
    if (push.places == 0u) {
        if (me == 0u) tile_begin[tile] = taken;
        return;
    }
    const uint begin = tile_begin[tile];
    uint rank = sums[me] - mine;
    for (uint i = 0u; i < TILE_ITEMS_EACH; ++i) {
        if (!is_left(first + i)) continue;
        if (rank < taken) of_cells[word_at(WORDS_TODO, begin + rank)] = first + i;
        if (push.keeps != 0u) of_cells[word_at(WORDS_KEPT, first + i)] |= KEPT_TRIED_AGAIN;
        ++rank;
    }
    if (me != 0u) return;
    if (all > 0u) atomicAdd(chunk.left_count, all);
    if (tile + 1u < tiles) return;
    const uint count = begin + taken, groups = (count + push.group - 1u) / push.group;
    chunk.todo_count = count;
    chunk.groups_x = min(groups, 65535u);  // the most that every device supports
    chunk.groups_y = (groups + 65534u) / 65535u;
    chunk.groups_z = 1u;
    chunk.subgroups_x = min(count, 65535u);
    chunk.subgroups_y = (count + 65534u) / 65535u;
    chunk.subgroups_z = 1u;
}

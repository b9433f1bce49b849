// Where the column of a cell is in the rows: KEPT_WORDS words. The .comp declares `push`, with keeps and cell_count, before.
#ifndef VOTESS_KEPT_KEPT_COLUMN_GLSL
#define VOTESS_KEPT_KEPT_COLUMN_GLSL

#include "kept/kept_word.glsl"

uint reach_place(uint cell) {
    return push.keeps + cell;
}
// Sorted seeds, or walls as planes of a cell.
uint plane_place(uint cell, uint plane) {
    return push.keeps + (1u + plane) * push.cell_count + cell;
}
// Three of these planes, 8 bits each.
uint corner_place(uint cell, uint corner) {
    return push.keeps + (1u + KEPT_PLANES + corner) * push.cell_count + cell;
}

#endif

// The words of a chunk. The .comp declares `push`, with cell_count, before.
#ifndef VOTESS_SHARED_CHUNK_GLSL
#define VOTESS_SHARED_CHUNK_GLSL

#include "shared/interface.h"
#include "shared/layout.h"

layout(std430, binding = BINDING_CHUNK) buffer Chunk {
    ChunkState chunk;
    uint of_cells[];
};

// Returns the place of a cell's word in `of_cells`. array: WORDS_.
uint word_at(uint array, uint cell) {
    return array * push.cell_count + cell;
}

uint word_of(uint array, uint cell) {
    return of_cells[word_at(array, cell)];
}

#endif

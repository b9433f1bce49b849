// What is known of a cell of a frame that keeps cells, in a word (KEPT_).
#ifndef VOTESS_KEPT_KEPT_WORD_GLSL
#define VOTESS_KEPT_KEPT_WORD_GLSL

#include "shared/config.h"

// Returns whether a cell needs no search: it holds, or it was tried in this frame.
bool is_done(uint kept) {
    return (kept & (KEPT_HELD | KEPT_TRIED)) != 0u;
}
uint kept_planes(uint kept) {
    return kept & 0xffu;
}
uint kept_corners(uint kept) {
    return (kept >> KEPT_CORNERS_SHIFT) & 0xffu;
}

#endif

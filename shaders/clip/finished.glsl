// Which cells need no further work on the device.
#ifndef VOTESS_CLIP_FINISHED_GLSL
#define VOTESS_CLIP_FINISHED_GLSL

#include "shared/config.h"

// Returns whether the info of a cell says that it is certified, or that its seed has no cell.
bool is_finished(uint info_of_cell) {
    const uint status_of_cell = info_of_cell & 0xffu;
    return status_of_cell == STATUS_CERTIFIED || status_of_cell == STATUS_DUPLICATE ||
           status_of_cell == STATUS_EMPTY || status_of_cell == STATUS_OUTSIDE;
}

#endif

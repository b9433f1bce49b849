// The data from which the passes of recorded frames make images of a triclinic box that repeats along all its edges.
#pragma once

#include "gpu/domain/units.hpp"
#include "shared/layout.h"
#include "votess/votess.hpp"

namespace votess::gpu {

struct CellImages {
    Box box;      // of seeds and images
    Box allowed;  // of seeds as given
    double volume = 0;
    LatticeData data{};
};

// Returns the data for images up to `margin` around the bounds of the box, or a smaller margin where these are too
// many. Allocates nothing. Throws invalid_argument as a cell of a run does, unsupported for a box that leans too much
// or is too thin.
CellImages cell_images(const TriclinicBox& cell, double margin);

}  // namespace votess::gpu

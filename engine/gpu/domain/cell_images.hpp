// Where recorded frames have the images of a triclinic box that repeats along all its edges: what the passes are told.
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

// With the images up to `margin` around the bounds of the box, or somewhat fewer where those were too many. Allocates
// nothing. Throws invalid_argument as Options::cell does, unsupported for a box that leans or is thin too much.
CellImages cell_images(const TriclinicBox& cell, double margin);

}  // namespace votess::gpu

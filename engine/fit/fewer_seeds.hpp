// A fit of a part of the seeds, as a start for all of them.
#pragma once

#include "fit/newton.hpp"

namespace votess::fit {

// Returns the problem of one seed of each group, which are consecutive, with the targets of the whole group.
[[nodiscard]] Problem fewer_seeds(const Problem& all);
// Returns weights with which each seed touches the cells of a fit of fewer_seeds(): it owns the centroid of one of them
// as much as the seed of that cell, and no other. From cell to neighboring cell the way there is short.
[[nodiscard]] Vector spread(const Problem& all, const Weighted& few);

}  // namespace votess::fit

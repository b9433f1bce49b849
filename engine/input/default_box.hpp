// The box of jobs without one.
#pragma once

#include "domain/domain.hpp"

namespace votess {

// Returns the bounds of the seeds, moved out by half of (longest side / cbrt(N)), at least to the next double. In the
// plane, with 2 dimensions, sqrt(N) takes the place of cbrt(N).
Box default_box(const Box& bounds, std::size_t count, int dimensions = 3);
// Returns the bounds of the polyhedron of the walls, moved out a little. Sides farther than a million times the size of
// `otherwise` have its bounds, and so has a polyhedron that is empty.
Box bounds_of(const std::vector<Wall>& walls, const Box& otherwise);

}  // namespace votess

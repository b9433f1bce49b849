// The box of jobs that give none.
#pragma once

#include "domain/domain.hpp"

namespace votess {

// Bounds of the seeds, moved out by half of (longest side / cbrt(N)), at least to the next double.
Box default_box(const Box& bounds, std::size_t count);
// Bounds of where all walls leave room, moved out by a little; those of `otherwise` where the walls leave room without
// bounds, which is what lies beyond a million times the size of `otherwise`, or none at all.
Box bounds_of(const std::vector<Wall>& walls, const Box& otherwise);

}  // namespace votess

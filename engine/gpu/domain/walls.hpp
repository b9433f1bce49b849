// Walls of any direction on a device, see shaders/clip/walls.glsl.
#pragma once

#include <vector>

#include "gpu/domain/units.hpp"
#include "input/job.hpp"

namespace votess::gpu {

// Returns whether there are walls of any direction, or seeds beyond walls. The device's box is then larger than the
// domain's, whose faces become such walls too. Otherwise ties of its corners with walls would be ties of many
// unfinished cells.
[[nodiscard]] inline bool has_device_walls(const Domain& domain) {
    return domain.has_cell_walls() || !domain.walls.empty() || domain.seeds_beyond;
}

// Returns the walls in the order of their ids, from -1 on, relative to the lower corner of the device's box. Walls that
// the domain lacks, or that cut nothing off its box, are far away.
[[nodiscard]] std::vector<WallPlane> device_walls(const Job& job, const Box& box);

}  // namespace votess::gpu

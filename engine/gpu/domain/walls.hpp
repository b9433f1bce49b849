// Walls of any direction as a device has them, see shaders/clip/walls.glsl.
#pragma once

#include <vector>

#include "gpu/domain/units.hpp"
#include "input/job.hpp"

namespace votess::gpu {

// Whether there are walls of any direction. The device's box then is larger than the domain's, whose faces count as
// such walls too: ties of its corners with walls would be ties of many cells before they are done.
[[nodiscard]] inline bool has_device_walls(const Domain& domain) {
    return domain.has_cell_walls() || !domain.walls.empty();
}

// In the order of their ids, from -1 on. box: the device's, from whose lower corner they count. Walls that the domain
// does not have, or that cut nothing off its box, are far away.
[[nodiscard]] std::vector<WallPlane> device_walls(const Job& job, const Box& box);

}  // namespace votess::gpu

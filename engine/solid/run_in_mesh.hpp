// A run in a closed triangle mesh.
#pragma once

#include "input/run_in_box.hpp"
#include "result/result.hpp"

namespace votess::solid {

// Returns the parts of the cells in options.mesh. Makes the cells in a box around the mesh, on any device. Then the CPU
// cuts those that triangles come near. The others are inside or outside as a whole: one ray decides for all of them
// that are connected.
[[nodiscard]] detail::Result run_in_mesh(const Points& points, const Options& options, const RunInBox& run);

struct BoxAround {
    Options options;  // with the box, without the mesh
    double mesh_volume = 0;
};
// Returns the box around options.mesh and the points in which the cells are made. Throws as check_in_mesh(), and for
// points that have no box.
[[nodiscard]] BoxAround box_around(const Points& points, const Options& options);

// Throws for options that do not go with a mesh, or for a mesh that is not closed.
void check_in_mesh(const Options& options);

}  // namespace votess::solid

// Where a mesh made from the cells on a surface differs from the surface.
#pragma once

#include "solid/closed_mesh.hpp"
#include "surface/features.hpp"
#include "surface/regions.hpp"
#include "votess/surface.hpp"

namespace votess::surface {

// Fills the figures of a mesh whose vertices, triangles and cells are known, and the faults. regions: of the vertices.
// surface: of the cells.
void report_on_mesh(Remesh& mesh, const Regions& regions, const Features& features, const solid::MeshArrays& surface);

}  // namespace votess::surface

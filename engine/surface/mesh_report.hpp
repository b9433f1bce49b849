// Where a mesh made from the cells on a surface differs from the surface.
#pragma once

#include <cstdint>
#include <vector>

#include "solid/closed_mesh.hpp"
#include "surface/features.hpp"
#include "votess/surface.hpp"

namespace votess::surface {

// Returns for each connected part of the cells whether it is at fault that triangles of parts do not fit together as
// the surface does: 1, else 0. Parts at edges of more than two triangles of the surface are not.
[[nodiscard]] std::vector<std::uint8_t> faulty_parts(const SurfaceCells& cells,
                                                     const std::vector<std::int32_t>& triangles,
                                                     const Features& features);

// Fills the figures of a mesh whose vertices, triangles and cells are known, and the faults. surface: of the cells.
void report_on_mesh(Remesh& mesh, const Features& features, const solid::MeshArrays& surface);

}  // namespace votess::surface

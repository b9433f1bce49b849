// The pieces of a sheet as those of the plane.
#pragma once

#include <cstdint>
#include <span>

#include "solid/mesh_cells.hpp"
#include "votess/pieces.hpp"

namespace votess::solid {

// prisms: pieces between the walls of a sheet, in the mesh of a Prism. edges: those given, of the edges of the mesh.
// Returns their outlines: edges instead of triangles, ring after ring, with the piece on the left, the outline first.
// No ring touches itself or crosses another. A source on the surface is an edge as given. Vertices of the mesh keep
// their places.
[[nodiscard]] Pieces flat_pieces(const Pieces& prisms, const MeshCells& cells, std::span<const std::int32_t> edges);

}  // namespace votess::solid

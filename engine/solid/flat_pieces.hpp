// The pieces of a sheet as those of the plane.
#pragma once

#include "votess/pieces.hpp"

namespace votess::solid {

// prisms: pieces between the walls of a sheet of this thickness, in the mesh of a Prism.
// Returns their outlines: edges instead of triangles, ring after ring, with the piece on the left. The longest ring of
// a piece is the first. A source on the surface is an edge of the mesh.
[[nodiscard]] Pieces flat_pieces(const Pieces& prisms, double thickness);

}  // namespace votess::solid

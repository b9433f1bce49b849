// Pieces as arrays of a caller in C.
#pragma once

#include <cstddef>

#include "c/handles.hpp"
#include "files/pieces.hpp"

namespace votess::c {

// Returns a view of the arrays. dimensions: of the vertices; a triangle has as many corners, and is an edge in the
// plane. Throws invalid_argument for arrays that do not fit together.
[[nodiscard]] files::Pieces checked_pieces(const votess_piece_arrays* pieces, std::size_t dimensions);

}  // namespace votess::c

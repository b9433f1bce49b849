// The faces of a clipped cell.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "polytope/cell.hpp"

namespace test {

// Returns the ids of the planes of the canonical faces, ascending.
inline std::vector<std::int32_t> faces_of(votess::cpu::Cell& cell) {
    votess::cpu::CellFaces faces;
    cell.canonical_faces(faces);
    std::vector<std::int32_t> ids;
    for (const std::int32_t p : faces.planes) ids.push_back(cell.planes()[static_cast<std::size_t>(p)].id);
    std::ranges::sort(ids);
    return ids;
}

}  // namespace test

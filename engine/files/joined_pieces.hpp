// The pieces of cells as one mesh, for solvers and meshers.
//
// Each cell was cut on its own: corners of two pieces at one place differ by rounding, and both triangulate the face
// between them. Here corners at one place become one vertex, and both pieces get the polygons of one of them. So each
// piece stays closed, as a sum of its sides, whatever vertices are joined.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "files/mesh.hpp"
#include "files/pieces.hpp"

namespace votess::files {

class JoinedPieces {
public:
    // Throws invalid_argument for pieces that do not touch, as those with a gap or of some cells alone.
    explicit JoinedPieces(const Pieces& pieces);

    // Returns a view with a cell for each piece. A patch is a connected part of the mesh's surface.
    [[nodiscard]] Mesh mesh() const;

private:
    std::vector<std::int64_t> indptr_, face_offsets_{0};
    std::vector<std::int32_t> indices_, planes_, face_vertices_, rows_;
    std::vector<double> vertices_;
    std::vector<std::string> patches_;
    double min_edge_;
    std::uint64_t* short_edges_;
    std::function<void(const SharedMesh&)> measure_;
};

}  // namespace votess::files

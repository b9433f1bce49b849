// Plane sections of closed triangle meshes: polygons with holes.
#pragma once

#include <votess/pieces.hpp>

#include "picture/mesh.hpp"

namespace votess::picture {

// Sections as the picture sees them: cells with rings, whose edges are faces. A piece may have several. Vertices lie on
// the plane, and those of edges that several triangles share are equal.
struct PieceSections {
    // slice: an axis of space, and a value.
    PieceSections(const Pieces& pieces, const Slice& slice);
    PieceSections(const PieceSections&) = delete;
    PieceSections& operator=(const PieceSections&) = delete;

    std::vector<std::size_t> piece;  // of each section
    Mesh mesh;

private:
    void add(std::size_t of, const std::vector<std::vector<Vec3>>& rings);

    std::vector<std::int64_t> indptr_{0}, offsets_{0};
    std::vector<std::int32_t> ids_, ends_;
    std::vector<double> vertices_;
};

}  // namespace votess::picture

// The faces of one cell as polygons, for the mesh.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "exact/predicate.hpp"

namespace votess::cpu {

class Cell;
struct CellFaces;

// Face f has the corners offsets[f]..offsets[f+1), counterclockwise seen from outside. Its first edge borders the
// neighboring face of least rank.
struct CellPolygons {
    std::vector<std::uint32_t> offsets{0};
    std::vector<std::uint32_t> corners;            // indices into `positions`, which may have more
    std::vector<std::uint32_t> first_across;       // by face: that rank
    std::vector<std::array<double, 3>> positions;  // relative to the seed, scaled
    std::vector<std::uint32_t> shared;             // numbers that cells of a stretch have in common; or empty

    [[nodiscard]] std::size_t size() const { return offsets.size() - 1; }
    [[nodiscard]] std::span<const std::uint32_t> face(std::size_t f) const {
        return std::span(corners).subspan(offsets[f], offsets[f + 1] - offsets[f]);
    }
    void clear() {
        offsets.assign(1, 0);
        corners.clear();
        first_across.clear();
        positions.clear();
        shared.clear();
    }
};

// Returns the outward unit normal of a plane as seen by a seed at p. Each component of the exact normal is rounded
// once. All rows take normals from here, so their digits do not depend on how a cell was found.
std::array<double, 3> unit_normal(const exact::Point& p, const exact::Plane& plane);

// faces: the canonical ones of the cell; ranks: by face, all different.
void read_polygons(const Cell& cell, const CellFaces& faces, std::span<const std::uint32_t> ranks, CellPolygons& out);

}  // namespace votess::cpu

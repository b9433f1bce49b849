// The faces of one cell as polygons: what the mesh is made from, however the cell was found.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace votess::cpu {

class Cell;
struct CellFaces;

// Face f has the corners offsets[f]..offsets[f+1), counterclockwise seen from outside. The edge from the first to the
// second of them is that of the face of least rank among those beside it.
struct CellPolygons {
    std::vector<std::uint32_t> offsets{0};
    std::vector<std::uint32_t> corners;            // vertices: places in `positions`, which may have others, too
    std::vector<std::uint32_t> beginnings;         // by face: that rank
    std::vector<std::array<double, 3>> positions;  // relative to the seed, scaled
    std::vector<std::uint32_t> shared;             // numbers that cells of a stretch have in common; or empty

    [[nodiscard]] std::size_t size() const { return offsets.size() - 1; }
    [[nodiscard]] std::span<const std::uint32_t> face(std::size_t f) const {
        return std::span(corners).subspan(offsets[f], offsets[f + 1] - offsets[f]);
    }
    void clear() {
        offsets.assign(1, 0);
        corners.clear();
        beginnings.clear();
        positions.clear();
        shared.clear();
    }
};

// No square leaves the range, and a subnormal vector, whose length would be rounded to few bits, is made longer first.
inline std::array<double, 3> unit_vector(const std::array<double, 3>& n) {
    const double length = std::hypot(n[0], n[1], n[2]);
    if (length < 0x1p-900) return unit_vector({n[0] * 0x1p500, n[1] * 0x1p500, n[2] * 0x1p500});
    return {n[0] / length, n[1] / length, n[2] / length};
}

// faces: the canonical ones of the cell; ranks: by face, all different.
void read_polygons(const Cell& cell, const CellFaces& faces, std::span<const std::uint32_t> ranks, CellPolygons& out);

}  // namespace votess::cpu

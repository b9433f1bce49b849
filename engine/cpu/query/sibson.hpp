// How much of the cell of a probe each of its neighbors had before: Sibson's natural-neighbor coordinates are these
// volumes over that of the cell (A vector identity for the Dirichlet tessellation, Math. Proc. Camb. Phil. Soc. 87,
// 1980).
//
// The cell P is divided by the bisectors between its neighbors. The edges of that division begin at the vertices of P:
// where three neighbors a, b, c are as near as the probe, the points that are as near to a, b and c lead inward, until
// a fourth, d, is as near. At such a vertex three more edges begin, each without one of the four, and lead to other
// vertices. The volume of a part is a sum over the edges of its faces: V x W, for an edge from V to W, sums to twice
// the area vector A of a face, and A.R / 3 is the volume of the pyramid between the face and the probe, with R on the
// face's plane.
//
// Where vertices of P have more than three faces, a wall is near, or rounding made the edges inconsistent, P is cut by
// the planes instead, once for each neighbor.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/convex_piece.hpp"
#include "cpu/clip/cell_polygons.hpp"

namespace votess::cpu {

// The cell of a probe. Plane f is n.x = h in coordinates relative to the probe; the faces of a polygon are in the order
// of planes.
struct ProbeShape {
    struct Plane {
        std::int32_t seed = 0;  // sorted; a wall below 0
        std::array<double, 3> n{};
        double h = 0;
    };
    std::vector<Plane> planes;
    CellPolygons polygons;
};

class SibsonVolumes {
public:
    // By plane: the volume of that neighbor's part; 0 for walls.
    std::span<const double> find(const ProbeShape& shape);

private:
    static constexpr std::size_t most_planes = 32;
    using Vector = std::array<double, 3>;

    struct Vertex {          // as near to four neighbors
        std::uint32_t near;  // bits of these
        std::uint32_t done;  // of these, bit a: the edge that leaves a is known
        Vector x;
    };
    struct Side {  // of a vertex of the cell: the edge that goes out along a face
        std::uint8_t face, to;
    };

    [[nodiscard]] bool by_edges(const ProbeShape& shape);
    [[nodiscard]] bool read(const ProbeShape& shape);
    [[nodiscard]] bool walk_inward();
    [[nodiscard]] bool walk_on();
    [[nodiscard]] Vector direction(std::size_t a, std::size_t b, std::size_t c) const;
    [[nodiscard]] bool leave(const Vector& from, std::uint32_t three, const Vector& along, Vector& to);
    void add_edge(std::uint32_t three, const Vector& from, const Vector& to);
    void add_across(std::size_t a, std::size_t b, const Vector& across);
    [[nodiscard]] Vector middle_of(std::size_t a, std::size_t b) const;
    [[nodiscard]] bool balanced() const;
    void by_cuts(const ProbeShape& shape);

    std::size_t count_ = 0;  // planes
    alignas(64) std::array<double, most_planes> nx_, ny_, nz_, h_;
    std::vector<double> volumes_;
    const Vector* positions_ = nullptr;       // vertices of the cell
    std::vector<std::array<Side, 3>> sides_;  // by vertex of the cell
    std::vector<std::uint8_t> sides_known_;
    std::vector<Vertex> vertices_;
    ConvexPiece whole_, part_;
    std::vector<Vector> corners_;
};

}  // namespace votess::cpu

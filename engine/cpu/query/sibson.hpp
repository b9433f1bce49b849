// The division of a probe's cell, from the cell alone.
//
// Its edges begin at the vertices of the cell: where three neighbors a, b, c are as near as the probe, the points that
// are as near to a, b and c lead inward, until a fourth, d, is as near. At such a vertex three more edges begin, each
// without one of the four, and lead to other vertices. A wall takes part as a neighbor that is reached, not approached.
//
// Where more than four neighbors are as near, or more than three faces of the cell meet, rounding would make the edges
// inconsistent. All of them, those of the cell too, are then found with planes that are moved by a little more than
// rounding is. Where that fails the cell is cut by the planes, once for each neighbor.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/convex_piece.hpp"
#include "cpu/clip/cell_polygons.hpp"
#include "cpu/query/division.hpp"

namespace votess::cpu {

// The cell of a probe. Plane f is n.x = h in coordinates relative to the probe; the faces of polygons are in the order
// of planes.
struct ProbeShape {
    struct Plane {
        std::int32_t seed = 0;  // sorted; a wall below 0
        std::array<double, 3> n{};
        double h = 0;
    };
    bool weighted = false;
    std::vector<Plane> planes;
    CellPolygons polygons;
};

class Sibson {
public:
    // False when the cell must be cut.
    [[nodiscard]] bool divide(const ProbeShape& shape, bool moments, Division& out);
    // Volumes by plane, 0 for walls.
    void cut(const ProbeShape& shape, std::vector<double>& volumes);

private:
    using Vector = std::array<double, 3>;

    struct Vertex {          // as near to four neighbors
        std::uint32_t near;  // bits of these
        std::uint32_t done;  // of these, bit a: the edge that leaves a is known
        Vector x;
        // By the edge of three of them; false when that is known.
        [[nodiscard]] bool reach(std::uint32_t three) {
            const std::uint32_t without = near & ~three;
            const bool is_new = (done & without) == 0;
            done |= without;
            return is_new;
        }
    };

    struct Limit {
        Vector n;
        double h;
    };
    static Limit limit(const ProbeShape& shape, std::size_t a, std::size_t b);
    void read_meetings(const CellPolygons& polygons);
    void cut_by(const ProbeShape& shape, std::size_t a, std::size_t b);
    void read(const ProbeShape& shape, double moved, bool moments, Division& out);
    [[nodiscard]] bool read_corners(const CellPolygons& polygons);
    [[nodiscard]] bool walk_surface(const CellPolygons& polygons, const Division& division);
    [[nodiscard]] bool walk_inward(Division& out);
    [[nodiscard]] bool walk_on(Division& out);
    [[nodiscard]] Vertex* find(std::uint32_t three, std::size_t begin);
    [[nodiscard]] std::size_t meet(const Vector& from, const Vector& along, std::uint32_t without, double excess,
                                   double speed, double& time) const;
    [[nodiscard]] std::size_t go(Vector& x, const Vector& along, std::uint32_t without) const;
    [[nodiscard]] bool leave(const Division& division, const Vector& from, std::uint32_t three, const Vector& along,
                             Vector& to);

    // By number, padded with planes that nothing meets up to a multiple of four.
    Division::Normals normals_{};
    std::size_t padded_ = 0;
    alignas(32) std::array<double, Division::most_neighbors> h_{}, approached_{};  // 1 for neighbors, 0 for walls
    std::array<std::uint8_t, Division::most_neighbors> number_{};                  // by plane of the shape
    struct Corner {  // of the cell, on three of its planes
        std::array<std::uint8_t, 3> planes;
        Vector x;
    };
    std::vector<Corner> corners_;
    std::vector<std::uint8_t> planes_known_;  // by vertex of the polygons
    std::vector<Vertex> vertices_;
    // For cut(): the faces that meet at vertex v, from meeting_begin_[v] on.
    std::vector<std::uint32_t> meeting_begin_, meeting_next_, meeting_;
    std::vector<bool> cut_done_;  // by plane
    ConvexPiece part_;
};

}  // namespace votess::cpu

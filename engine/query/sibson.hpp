// The division of a probe's cell, from the cell alone.
//
// Its inner edges begin at the vertices of the cell, where three neighbors a, b, c are as near as the probe. The points
// equally near to a, b and c lead inward until a fourth neighbor d is as near. At that vertex three more edges begin,
// each without one of the four. A wall counts as a neighbor that the edge reaches.
//
// The walk runs in floating point and proves each vertex: it lies inside of all other planes by more than rounding may
// have moved it. Where that fails, as on lattices, or where digits are lost, the caller divides with Parts.
//
// Margin. Let N be the length of the longest normal, R the distance of the farthest corner and H the largest height.
// A residual h - n.x of rounded n, h and x = from + t along errs by less than 30 u (N R + H). The difference of two
// errs by less than `rounding_` = 64 u (N R + H). Let dx be the distance of a computed vertex from the true one. Then M
// dx = r, where the rows of M are three differences of normals and |r| is within rounding_. So |dx| <= 12 N^2 rounding_
// / |det M|. That changes other differences of residuals by at most 2 N |dx|.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "polytope/cell_polygons.hpp"
#include "query/division.hpp"

namespace votess::cpu {

// The cell of a probe. Plane f is n.x = h in coordinates relative to the probe; the faces of polygons are in the order
// of planes.
struct ProbeShape {
    struct Plane {
        std::int32_t seed = 0;  // sorted; a wall below 0
        std::array<double, 3> n{};
        double h = 0;
    };
    struct Corner {
        std::array<std::uint8_t, 3> planes;
        std::array<double, 3> x;
    };
    bool weighted = false;
    std::vector<Plane> planes;
    CellPolygons polygons;
    std::vector<Corner> corners;

    // Fills `corners`. Returns false when some vertex lies on more than three faces.
    [[nodiscard]] bool find_corners();

private:
    std::vector<std::uint8_t> planes_known_;  // by vertex of the polygons
};

class Sibson {
public:
    // Divides a shape whose corners are known. Returns false where rounding might matter.
    [[nodiscard]] bool divide(const ProbeShape& shape, bool moments, Division& out);
    // After it: visit(x, power, error) for each vertex inside the cell of a probe of that weight, as for NearerSeeds.
    template <class Visit>
    void for_vertices(double weight, Visit visit) const {
        for (const Vertex& v : vertices_)
            visit(v.x, v.x[0] * v.x[0] + v.x[1] * v.x[1] + v.x[2] * v.x[2] - weight + 2 * v.excess, v.error);
    }

private:
    using Vector = std::array<double, 3>;

    struct Vertex {          // as near to four neighbors
        std::uint32_t near;  // bits of these
        std::uint32_t done;  // of these, bit a: the edge that leaves a is known
        Vector x;
        double excess;  // half of the power of the neighbors minus that of the probe
        double error;   // a bound, of x
        // By the edge of three of them; false when that is known.
        [[nodiscard]] bool reach(std::uint32_t three) {
            const std::uint32_t without = near & ~three;
            const bool is_new = (done & without) == 0;
            done |= without;
            return is_new;
        }
    };
    void read(const ProbeShape& shape, bool moments, Division& out);
    [[nodiscard]] bool neighbors_are_apart(std::size_t neighbors) const;
    [[nodiscard]] bool walk_inward(const ProbeShape& shape, Division& out);
    [[nodiscard]] bool walk_on(Division& out);
    [[nodiscard]] Vertex* find(std::uint32_t three, std::size_t begin);
    [[nodiscard]] std::size_t meet(const Vector& from, const Vector& along, std::uint32_t without, double excess,
                                   double speed, double& time);
    [[nodiscard]] bool is_proven(double time, double own, std::uint32_t near, double margin);
    [[nodiscard]] bool leave(const Division& division, const Vector& from, std::uint32_t three, const Vector& along,
                             Vector& to);

    // By number, padded with planes that nothing meets to an even number.
    Division::Normals normals_{};
    std::size_t padded_ = 0;
    alignas(16) std::array<double, Division::max_neighbors> h_{}, approached_{};  // 1 for neighbors, 0 for walls
    alignas(16) std::array<double, Division::max_neighbors> far_{};               // 0 for neighbors, else never
    // Of the last ray: the residuals at its start, and their decrease along it.
    alignas(16) std::array<double, Division::max_neighbors> left_{}, nearing_{};
    std::array<std::uint8_t, Division::max_neighbors> number_{};    // by plane of the shape
    double rounding_ = 0;                                           // of differences of residuals
    double longest_ = 0, longest_squared_ = 0, longest_cubed_ = 0;  // normal
    std::vector<Vertex> vertices_;
};

}  // namespace votess::cpu

// A Delaunay triangulation that grows point by point (Bowyer 1981, Watson 1981), with exact predicates.
//
// A point inside the circumsphere of a tetrahedron is in conflict with it; a new point replaces the tetrahedra that it
// is in conflict with by those that join it to their common boundary. A vertex at infinity closes the hull: behind each
// triangle of it lies an infinite tetrahedron.
//
// Ties. A point on a circumsphere is not in conflict. This is a consistent perturbation: lift points to
// (x, |x|^2 + e_i), with e_i > 0 infinitesimal and each point's far greater than those of all points before it; the
// newest point's then decides every tie (Devillers and Teillaud, Perturbations for Delaunay and weighted Delaunay 3D
// triangulations, Comput. Geom. 44(3), 2011, who sort points another way). The result is the regular triangulation
// with these weights: orientations are not perturbed, and no tetrahedron is flat. A point in the plane of a hull
// triangle is in conflict with the infinite tetrahedron when it is with the finite one across: in that plane both
// circumspheres have the circle of the triangle, and of the weights only the triangle's and the point's count.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "exact/predicate.hpp"

namespace votess::cpu {

// orient(vertices) > 0, where the infinite vertex stands for any point beyond the hull triangle.
struct Tetrahedron {
    std::array<std::int32_t, 4> vertex;    // indices of points
    std::array<std::int32_t, 4> neighbor;  // across the face opposite to that vertex
};

class Triangulation {
public:
    static constexpr std::int32_t infinite = -1;
    static constexpr std::int32_t unused = -2;  // vertex[0] of a free place

    // The points must stay; no two that are inserted may be equal.
    explicit Triangulation(std::span<const exact::Point> points) : points_(points) {}

    // The first four points, not coplanar. Later infinitesimal weights are greater than those.
    void begin(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d);
    void insert(std::int32_t point);

    [[nodiscard]] std::span<const Tetrahedron> tetrahedra() const { return cells_; }
    [[nodiscard]] std::vector<Tetrahedron> take() { return std::move(cells_); }
    [[nodiscard]] static bool is_finite(const Tetrahedron& t) {
        return t.vertex[0] >= 0 && t.vertex[1] >= 0 && t.vertex[2] >= 0 && t.vertex[3] >= 0;
    }

private:
    enum class State : std::uint8_t { unknown, conflict, kept, fresh };
    struct Boundary {  // the face of `cell`, which is in conflict, opposite to its vertex `slot`
        std::int32_t cell;
        std::int32_t slot;
        std::int32_t fresh;  // the tetrahedron made on it
    };

    // A tetrahedron that the point is in conflict with.
    [[nodiscard]] std::int32_t locate(std::int32_t point);
    [[nodiscard]] int orient_with(const Tetrahedron& t, int slot, std::int32_t point) const;
    [[nodiscard]] bool in_conflict(const Tetrahedron& t, std::int32_t point) const;
    void find_conflicts(std::int32_t point);
    void fill_hole(std::int32_t point);
    void link(const Boundary& face);
    [[nodiscard]] std::int32_t allocate_cell();

    std::span<const exact::Point> points_;
    std::vector<Tetrahedron> cells_;
    std::vector<State> state_;  // of each cell while a point is inserted
    std::vector<std::int32_t> free_, conflicts_, kept_;
    std::vector<Boundary> boundary_;
    std::int32_t last_ = 0;  // a finite tetrahedron of the last point
};

}  // namespace votess::cpu

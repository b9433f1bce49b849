// A Delaunay triangulation that grows point by point (Bowyer 1981, Watson 1981), with exact predicates.
//
// A point conflicts with a tetrahedron if it lies inside its circumsphere. A new point replaces the tetrahedra in
// conflict by those that join it to their common boundary. A vertex at infinity closes the hull: behind each hull
// triangle is an infinite tetrahedron.
//
// Ties. A point on a circumsphere is not in conflict. This is a consistent perturbation: points are lifted to (x, |x|^2
// + e_i), where e_i > 0 is infinitesimal and far greater than those of all earlier points. So the newest point decides
// every tie (Devillers and Teillaud, Perturbations for Delaunay and weighted Delaunay 3D triangulations, Comput. Geom.
// 44(3), 2011, who sort points in another way). The result is the regular triangulation with these weights:
// orientations are not perturbed, and no tetrahedron is flat. A point in the plane of a hull triangle conflicts with
// the infinite tetrahedron if it conflicts with the finite one across. In that plane both circumspheres have the circle
// of the triangle, and only the weights of the triangle and the point count.
//
// Points may have weights of their own. "Inside a sphere" then means a smaller power than the points of the
// tetrahedron. A point that conflicts with no tetrahedron is hidden and left out, and others may hide later.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "exact/predicate.hpp"

namespace votess::cpu {

// orient(vertices) > 0, where the infinite vertex is any point beyond the hull triangle.
struct Tetrahedron {
    std::array<std::int32_t, 4> vertex;    // indices of points
    std::array<std::int32_t, 4> neighbor;  // across the face opposite to that vertex
};

// The points of a triangulation, by index: the signs of exact predicates.
class Sites {
public:
    Sites() = default;
    Sites(const Sites&) = delete;
    Sites& operator=(const Sites&) = delete;
    virtual ~Sites() = default;
    // Returns the sign of det(a - d, b - d, c - d).
    [[nodiscard]] virtual int orient(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const = 0;
    // Returns +1 when p conflicts with the tetrahedron, where orient(a, b, c, d) > 0; 0 for a tie.
    [[nodiscard]] virtual int insphere(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d,
                                       std::int32_t p) const = 0;
};

// Points without weights, which must outlive this.
class PointSites final : public Sites {
public:
    explicit PointSites(std::span<const exact::Point> points) : points_(points) {}
    [[nodiscard]] int orient(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const override;
    [[nodiscard]] int insphere(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d,
                               std::int32_t p) const override;

private:
    std::span<const exact::Point> points_;
};

class Triangulation {
public:
    static constexpr std::int32_t infinite = -1;
    static constexpr std::int32_t unused = -2;  // vertex[0] of a free place

    // The sites must outlive this. No two inserted points without weights may be equal.
    explicit Triangulation(const Sites& sites) : sites_(sites) {}

    // Inserts the first four points, not coplanar. Their infinitesimal weights are smaller than later ones.
    void begin(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d);
    // Leaves a hidden point out.
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

    // Returns a tetrahedron that conflicts with the point unless it is hidden.
    [[nodiscard]] std::int32_t locate(std::int32_t point);
    [[nodiscard]] int orient_with(const Tetrahedron& t, int slot, std::int32_t point) const;
    [[nodiscard]] bool in_conflict(const Tetrahedron& t, std::int32_t point) const;
    // Returns whether there are any.
    [[nodiscard]] bool find_conflicts(std::int32_t point);
    void fill_hole(std::int32_t point);
    void link(const Boundary& face);
    [[nodiscard]] std::int32_t allocate_cell();

    const Sites& sites_;
    std::vector<Tetrahedron> cells_;
    std::vector<State> state_;  // of each cell while a point is inserted
    std::vector<std::int32_t> free_, conflicts_, kept_;
    std::vector<Boundary> boundary_;
    std::int32_t last_ = 0;  // a finite tetrahedron of the last point
};

}  // namespace votess::cpu

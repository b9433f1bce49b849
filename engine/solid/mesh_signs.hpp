// The decisions on which a cell in a mesh rests: where vertices and edges of the mesh lie, seen from bisectors.
//
// In a periodic domain an image of the cell may reach the mesh. Bisectors then count from the seed, and vertices of the
// mesh from its image. Both differences are exact sums.
//
// Let s_k(u) be the value of bisector k of a seed at a place u: the power of u from the seed, less that from the
// neighbor. It is negative inside. Every question is the sign of a determinant of such values, with a row for each
// bisector and a column for each vertex of the mesh:
//     a vertex u of the mesh                    outside f:     s_f(u)
//     the edge AB of the mesh on bisector a     outside f:     | s_f(A) s_f(B) ; s_a(A) s_a(B) | / (s_a(B) - s_a(A))
//     the triangle uvw on bisectors a and b     outside f:     | a ; b ; f | / D,  D = sum of s_a x s_b
//     the vertex of bisectors a, b, c           below uvw:     | a ; b ; c | / det(Na, Nb, Nc)
//     that vertex, seen along z,                left of uv:    the same with Nz instead of the last column
//     the line of a and b                       meets uvw before xyz: |a ; b ; coordinates of vertices| / D of each
// Where a triangle is clipped to a convex polygon, the signs of the denominators are known.
//
// Ties. The cell counts as shrunk towards a center inside of it, by less than any distance. Then s_k(u) grows by e
// times -s_k(center), the same in a row, so that the determinant is linear in it. Then the mesh counts as moved by
// (e^2, e^3, e^4) (Edelsbrunner and Mücke, ACM TOG 9(1), 1990). So no four planes meet, and a triangle that meets a
// cell meets its interior. The center is the seed, or another place where weights put the seed outside of its cell.
//
// With ranks of seeds, ties have another rule, by which cells tile a surface: the weight of each seed counts as larger
// by less than any number, most for the lowest rank. Then s_k(u) grows with the weight of the neighbor, and falls with
// that of the seed, the same in a row. The coefficient of each such step is a determinant of lower order, so no sign is
// 0.
//
// Values are computed in double with a bound on their error. Where the bound hides a sign, integers decide, on the
// float64 input.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "exact/integer/rows.hpp"
#include "exact/predicate.hpp"

namespace votess::solid {

inline constexpr double unit = 0x1p-53;  // rounding of one operation
inline constexpr double tiny = 1e-290;   // covers products that underflow

class MeshSigns {
public:
    // A value s_k(u), the bound on its error, and its sign after ties; 0 while that is unknown.
    struct Value {
        double s = 0, error = 0;
        int sign = 0;
        bool tie = false;  // s is exactly 0
    };
    // A vertex of the mesh, relative to the seed too.
    struct Place {
        exact::Point x, relative;
    };
    using Values = std::array<Value, 3>;  // at the vertices of a triangle
    using Places = std::array<Place, 3>;

    // image: the seed's place in the mesh, as if it were a bisector's. rank: of the seed, if ranks decide ties.
    void begin(const exact::Point& seed, const exact::Plane& image, std::int32_t rank = -1) {
        seed_ = seed;
        image_ = image;
        center_ = {};
        centered_ = true;
        bisectors_.clear();
        sources_.clear();
        ranks_.clear();
        rank_ = rank;
    }
    // rank: of the neighbor, other than all before.
    void add(const exact::Plane& bisector, std::int32_t rank = -1);
    // Returns how many signs were decided as ties so far.
    [[nodiscard]] std::size_t ties() const { return ties_; }
    // Sets the center after all bisectors: the seed, or `middle`, relative to it. If neither lies inside for sure, the
    // seed is the center, and some planes move outward.
    void find_center(const exact::Point& middle);
    void set_center(const MeshSigns& of) { center_ = of.center_, centered_ = of.centered_; }
    [[nodiscard]] std::array<double, 3> normal(std::size_t k) const { return bisectors_[k].n; }
    [[nodiscard]] Place place(const exact::Point& x) const {
        if (image_.lattice == nullptr) return {x, {x[0] - seed_[0], x[1] - seed_[1], x[2] - seed_[2]}};
        const auto d = exact::image_differences(x, image_).x;
        return {x, {-d[0].high, -d[1].high, -d[2].high}};
    }

    // Returns the value at a vertex, without its sign.
    [[nodiscard]] Value value(std::size_t k, const Place& u) const {
        const Bisector& b = bisectors_[k];
        const auto& r = u.relative;
        const double x = b.n[0] * r[0], y = b.n[1] * r[1], z = b.n[2] * r[2];
        const double error = value_rounding * (2 * (std::abs(x) + std::abs(y) + std::abs(z)) + b.size) + tiny;
        const double s = 2 * (x + y + z) - b.constant;
        return {s, error, s > error ? 1 : s < -error ? -1 : 0, false};
    }
    void find_sign(std::size_t k, const Place& u, Value& value) const;
    // Returns whether the place where the edge of the mesh from A to B crosses bisector a lies outside f: +1 or -1. The
    // signs at A and B of a differ.
    [[nodiscard]] int edge_side(std::size_t f, std::size_t a, const Place& at_a, const Place& at_b, const Value& fa,
                                const Value& fb, const Value& aa, const Value& ab) const;
    // Returns the sign of the determinant of three bisectors at three vertices.
    [[nodiscard]] int determinant(const std::array<std::size_t, 3>& k, const Places& u, const Values& a,
                                  const Values& b, const Values& c) const;
    // Returns the same with the z components of the normals in place of the third column.
    [[nodiscard]] int upright_determinant(const std::array<std::size_t, 3>& k, const Place& u, const Place& v) const;
    // Compares where the line of bisectors a and b meets two triangles, in the direction of the cross product of their
    // normals: -1 if it meets u first, +1 if v, 0 if both always lie in one plane.
    [[nodiscard]] int crossing_order(std::size_t a, std::size_t b, const Places& u, const Places& v) const;

private:
    static constexpr double value_rounding = 16 * 0x1p-53;
    struct Bisector {
        std::array<double, 3> n;
        double constant, size;  // |n|^2 + power; of its terms
    };
    // rows: `count` bisectors; columns: as many vertices, the last of them the direction z if `upright`.
    [[nodiscard]] int exact_sign(int count, const std::array<std::size_t, 3>& rows,
                                 const std::array<const exact::Point*, 3>& columns, bool upright) const;
    template <int W>
    [[nodiscard]] int integer_sign(int count, const std::array<std::size_t, 3>& rows,
                                   const std::array<const exact::Point*, 3>& columns, bool upright, int quantum) const;
    // Returns the sign after the first step of weights that changes it. sign_after(step): step by row.
    template <int W, class SignAfter>
    [[nodiscard]] int rank_sign(int count, const std::array<std::size_t, 3>& rows, SignAfter sign_after) const;
    template <int W>
    [[nodiscard]] int integer_order(const std::array<std::size_t, 2>& rows, const std::array<const Places*, 2>& u,
                                    int quantum) const;
    [[nodiscard]] bool holds(const exact::Point& center) const;
    [[nodiscard]] int sign_of_step(std::size_t k) const;
    [[nodiscard]] exact::BitRange range_of(std::span<const std::size_t> rows) const;

    exact::Point seed_{};
    exact::Plane image_;
    exact::Point center_{};  // relative to the seed
    bool centered_ = true;   // inside all bisectors
    std::vector<Bisector> bisectors_;
    std::vector<exact::Plane> sources_;  // of bisectors_
    std::vector<std::int32_t> ranks_;    // of bisectors_
    std::int32_t rank_ = -1;
    mutable std::size_t ties_ = 0;
};

// Returns the sign of component `axis` of (v - u) x (w - u). Exact.
int cross_sign(const exact::Point& u, const exact::Point& v, const exact::Point& w, int axis);

}  // namespace votess::solid

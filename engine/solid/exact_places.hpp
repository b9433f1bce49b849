// Corners of a cell in a mesh as quotients of integers.
//
// Values s_k(u) as in mesh_signs.hpp. Corners are relative to an origin o:
//     a vertex u of the mesh                   u - o
//     the edge AB of the mesh on bisector a    (s_a(B) (A - o) - s_a(A) (B - o)) / (s_a(B) - s_a(A))
//     the triangle uvw on bisectors a and b    sum of w_i (u_i - o) / sum of w_i,  w = s_a x s_b
//     the vertex of planes a, b, c             V / (2 D) - o, see exact/predicate.cpp
// So each corner, and each sum over corners, can be rounded from its exact value.
#pragma once

#include <array>
#include <vector>

#include "exact/integer/big_int.hpp"
#include "exact/integer/rows.hpp"
#include "exact/predicate.hpp"

namespace votess::solid {

// The place x / w, in units of 2^quantum; w is positive.
struct ExactPlace {
    std::array<exact::BigInt, 3> x;
    exact::BigInt w;
};

class ExactPlaces {
public:
    // Begins a cell. image: the seed's place in the mesh, as if it were a bisector's. origin: relative to the seed.
    void begin(const exact::Point& seed, const exact::Plane& image, const exact::Point& origin);
    // Includes all planes and vertices of the mesh that later calls name. Planes count from 0.
    void include(const exact::Plane& plane);
    void include(const exact::Point& vertex) { range_.add(vertex); }
    // Ends these calls.
    void prepare();

    [[nodiscard]] int quantum() const { return quantum_; }
    [[nodiscard]] ExactPlace vertex(const exact::Point& u) const;
    [[nodiscard]] ExactPlace on_edge(std::size_t a, const exact::Point& from, const exact::Point& to) const;
    [[nodiscard]] ExactPlace on_triangle(std::size_t a, std::size_t b, const std::array<exact::Point, 3>& u) const;
    [[nodiscard]] ExactPlace meeting(std::size_t a, std::size_t b, std::size_t c) const;

private:
    using Integers = std::array<exact::BigInt, 3>;
    struct Row {
        Integers n;
        exact::BigInt s;
    };
    [[nodiscard]] Integers relative(const exact::Point& u) const;  // to the seed
    [[nodiscard]] exact::BigInt value(std::size_t k, const Integers& u) const;
    [[nodiscard]] bool narrow() const { return range_.span() <= exact::middle_bits - 10; }

    exact::Point seed_{}, origin_{};
    exact::Plane image_;
    exact::BitRange range_;
    int quantum_ = 0;
    std::vector<exact::Plane> planes_;
    std::vector<Row> rows_;  // by plane
    Integers to_origin_;     // from the seed
};

}  // namespace votess::solid

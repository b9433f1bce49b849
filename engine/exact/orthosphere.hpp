// The smallest sphere orthogonal to the seeds of an edge, a triangle or a tetrahedron: without weights, the smallest
// sphere through them. Its center lies in their line, plane or space.
//
// A seed is opposite to a face of the simplex. It lies strictly inside the smallest sphere of that face exactly if its
// barycentric coordinate of the center is negative. If that is 0, the spheres of simplex and face are the same.
//
// Let seed 0 have weight w. From there the others lie at N_i, and the bisectors with them are 2 N_i.c = S_i, as in
// predicate.hpp. C_1 is N_2 x N_3, and so on. This is the center c, and its barycentric coordinates:
//     edge         c = S N / (2a)                            coordinate 1: S / (2a)                  a = |N|^2
//     triangle     |c|^2 = |S_1 N_2 - S_2 N_1|^2 / (4G)      1: (|N_2|^2 S_1 - N_1.N_2 S_2) / (2G)   G = |N_1 x N_2|^2
//     tetrahedron  c = V / (2D),  V = sum S_i C_i            i: V.C_i / (2 D^2)                      D = N_1.C_1
// All coordinates sum to 1. The square of the radius is |c|^2 - w.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/vector3.hpp"
#include "exact/predicate.hpp"

namespace votess::exact {

// The sphere of K + 1 seeds.
template <std::size_t K>
struct Orthosphere {
    double square;                         // of the radius
    std::array<std::int8_t, K + 1> signs;  // of the barycentric coordinates of the center, seed by seed
};

// Returns the sphere if double precision is sure of the signs, and of the square to 2^-40. Seeds are seen from seed 0,
// with coordinates rounded once. powers: the weight of seed 0 less those of the others, rounded. weight: of seed 0.
template <std::size_t K>
std::optional<Orthosphere<K>> sure_orthosphere(const std::array<Vector3, K>& seeds, const std::array<double, K>& powers,
                                               double weight);
// Returns the sphere. The square is rounded correctly, except in its last bit. Seeds must not be dependent. bisectors:
// with the others.
template <std::size_t K>
Orthosphere<K> orthosphere(const Point& seed, double weight, const std::array<Plane, K>& bisectors);

}  // namespace votess::exact

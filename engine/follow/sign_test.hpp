// The signs of kept cells at new places, in floating point with a bound on all rounding, for several instruction sets.
// A sign that the bound does not settle counts as wrong, so results do not depend on the choice.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "follow/kept_cell.hpp"
#include "polytope/cell_shape.hpp"

namespace votess::cpu {

struct alignas(32) SeedPlace {
    double x[3], weight;
};

struct alignas(32) SignWall {
    double n[3], offset;  // of the plane n.x = offset, rounded; n has length 1
};

struct SignFrame {
    const SeedPlace* places;  // by sorted seed
    const SignWall* walls;    // by -1 - id
    double wall_error;        // bound on the error of a seed's distance from a wall, except its own rounding
    bool weighted;
    double vector[3][3];  // of the box, rounded
    // Short vectors of the lattice, and with d_i.s_j = 1 for i = j, else 0. 0 along axes that do not repeat.
    double short_vector[3][3], dual[3][3];
    double slack;          // bound on the error of a difference of coordinates, except its own rounding
    double reach_squared;  // a corner beyond is wrong
    double point[3];       // see KeptCells::covers_once()
    friend bool operator==(const SignFrame&, const SignFrame&) = default;
};

// Returns the way to a place, or to an image of it about as near as any.
inline std::array<double, 3> nearest_way(const SignFrame& frame, const double* from, const double* to) {
    std::array<double, 3> way;
    for (std::size_t k = 0; k < 3; ++k) way[k] = to[k] - from[k];
    for (std::size_t j = 0; j < 3; ++j) {
        const double *const s = frame.short_vector[j], *const d = frame.dual[j];
        const double turns = std::rint(way[0] * d[0] + way[1] * d[1] + way[2] * d[2]);
        for (std::size_t k = 0; k < 3; ++k) way[k] -= turns * s[k];
    }
    return way;
}

// Scratch and outcome. Margins above 0 are right signs.
struct alignas(64) SignTest {
    static constexpr int max_tests = 3 * CellShape::max_corners / 2;
    // Of KeptCell::planes(): n.x = d, relative to the seed, as n and -d times a power of two.
    alignas(32) double plane[CellShape::max_planes][4];
    double scale[CellShape::max_planes];
    alignas(32) double corner[CellShape::max_corners][4];  // in homogeneous numbers
    double corner_margin[CellShape::max_corners];
    double test_margin[max_tests];
    double test_bound;    // on the errors of these
    bool tested = false;  // else there are no margins
};

// Returns whether all signs are right: each corner is on the right side of its planes, each edge has its ends in the
// right order, and no corner is beyond reach.
using SignTester = bool (*)(const SignFrame&, std::size_t seed, const KeptCell&, SignTest&);
// instructions: see supported_kernels().
SignTester sign_tester(std::string_view instructions);
bool test_signs_avx2(const SignFrame&, std::size_t seed, const KeptCell&, SignTest&);

}  // namespace votess::cpu

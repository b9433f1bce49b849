// The faces of a cell in rational arithmetic.
#pragma once

#include <gmpxx.h>

#include <array>
#include <optional>
#include <span>
#include <vector>
#include <votess/votess.hpp>

#include "oracle/half_spaces.hpp"

namespace test {

using RationalVector = std::array<mpq_class, 3>;

struct ExactPolygon {
    ExactFace face;
    RationalVector n;                     // outward
    mpq_class h;                          // n.x = h, relative to the seed
    std::vector<RationalVector> corners;  // relative to the seed, counterclockwise seen from outside
};

// Returns the faces that exact_cell() counts, in their order.
std::vector<ExactPolygon> exact_polygons(std::span<const double> points, const votess::Options& options, std::size_t i,
                                         std::optional<int> reach = {});

mpq_class dot(const RationalVector& a, const RationalVector& b);
RationalVector cross(const RationalVector& a, const RationalVector& b);
// Clips a convex polygon to n.x <= h. Leaves no corners if no area is left, unless it lies in the plane.
void clip(std::vector<RationalVector>& polygon, const RationalVector& n, const mpq_class& h);
// Returns twice the area as a vector along the normal.
RationalVector doubled_area(const std::vector<RationalVector>& polygon);

}  // namespace test

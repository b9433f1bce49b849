// The faces of a cell in rational arithmetic.
#pragma once

#include <gmpxx.h>

#include <array>
#include <optional>
#include <span>
#include <vector>
#include <votess/votess.hpp>

#include "oracle/half_spaces.hpp"
#include "support/vectors.hpp"

namespace test {

// n.x <= h, of x relative to the seed. Of a bisector n leads to the other seed.
struct HalfSpace {
    ExactFace face;
    RationalVector n;
    mpq_class h;
    [[nodiscard]] bool bisector() const { return face.id >= 0; }
};

struct ExactPolygon : HalfSpace {
    std::vector<RationalVector> corners;  // relative to the seed, counterclockwise seen from outside
};

// Returns the half-spaces of all seeds, those of images by -reach .. reach, and of all walls; see exact_cell().
std::vector<HalfSpace> half_spaces(std::span<const double> points, const votess::Options& options, std::size_t i,
                                   std::optional<int> reach = {});
// Returns the faces of the polytope inside all half-spaces, none if it has no volume. In a plane that several share the
// face is the first wall's, or that of the seed farthest behind. width: about how far the polytope reaches.
std::vector<ExactPolygon> polytope(std::vector<HalfSpace> all, double width);
// Returns the faces that exact_cell() counts, in their order.
std::vector<ExactPolygon> exact_polygons(std::span<const double> points, const votess::Options& options, std::size_t i,
                                         std::optional<int> reach = {});
mpq_class volume_of(std::span<const ExactPolygon> faces);

// Clips a convex polygon to n.x <= h. Leaves no corners if no area is left, unless it lies in the plane.
void clip(std::vector<RationalVector>& polygon, const RationalVector& n, const mpq_class& h);
// Returns twice the area as a vector along the normal.
RationalVector doubled_area(const std::vector<RationalVector>& polygon);

}  // namespace test

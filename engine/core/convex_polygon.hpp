// A convex polygon in space, in floating point, cut plane by plane.
#pragma once

#include <utility>
#include <vector>

#include "core/vector3.hpp"

namespace votess {

// Two parts of a cut share the side between them, whatever rounding does to the signs of corners near the plane. So
// they add up to the whole, also if the polygon lies in the plane.
class ConvexPolygon {
public:
    std::vector<Vector3> corners;  // around it

    [[nodiscard]] bool empty() const { return corners.size() < 3; }
    // Returns the smallest and the largest n.x. Not for an empty polygon.
    [[nodiscard]] std::pair<double, double> extent(const Vector3& n) const;
    // Keeps the part where n.x >= h. `below` becomes the rest.
    void split(const Vector3& n, double h, ConvexPolygon& below);

private:
    std::vector<double> beyond_;  // by corner: distance beyond the plane, times |n|
    std::vector<Vector3> kept_;   // scratch
};

}  // namespace votess

// Vertices where more than three planes of a cell meet, as in every lattice.
#pragma once

#include <span>

#include "exact/predicate.hpp"

namespace votess::exact {

// Finds the planes that own an edge at a vertex through which all planes pass. Writes their indices to `out`, which has
// room for planes.size(), and returns the part written. The order is counterclockwise seen from outside: consecutive
// planes turn left (orientation() > 0). Empty when the normals span no solid angle.
//
// They are the extreme rays of the cone of normals: the corners of the convex hull of the points N / (N.X) in the plane
// dual to the vertex X. Planes that only touch the vertex lie inside the hull, planes that touch a whole edge in the
// middle of a hull edge. Both are skipped, and so are all but the first of equal planes.
//
// Exact for any float64. Allocates only for more than 64 planes, or for coordinates that span more than 124 bits.
std::span<int> corner_polygon(const Point& p, std::span<const Plane* const> planes, std::span<int> out);

}  // namespace votess::exact

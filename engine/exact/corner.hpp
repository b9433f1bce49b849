// Vertices where more than three planes of a cell meet, as in every lattice.
#pragma once

#include <span>

#include "exact/predicate.hpp"

namespace votess::exact {

// All planes pass through one vertex of the cell. Those that own an edge there, counterclockwise seen from outside
// (consecutive ones turn left: orientation() > 0), are written to `out`, which holds planes.size(), as indices into
// `planes`; the part written is returned.
//
// They are the extreme rays of the cone of normals, that is, the corners of the convex hull of the points N / (N.X) in
// the plane dual to the vertex X. Left out are planes that only touch the vertex (inside the hull) or a whole edge (in
// the middle of a hull edge), and all but the first of equal planes. Empty when the normals span no solid angle.
//
// Exact for any float64. Allocates only for more than 64 planes, or coordinates that span more than 124 bits.
std::span<int> corner_polygon(const Point& p, std::span<const Plane* const> planes, std::span<int> out);

}  // namespace votess::exact

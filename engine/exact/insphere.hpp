// The two predicates of a Delaunay triangulation, and the normal of a triangle, exact for all float64 coordinates: a
// filter in double, then integers as wide as the operands need. The coordinates are integers times a common power of
// two.
//
// The filter decides almost nothing for seeds on a sphere, so the first integer tier has to be fast. The differences to
// one of the points are exact as sums of two doubles. They fit 61 bits unless a coordinate is far smaller than the
// largest difference; the determinant then fits 320 bits.
//
// Filter: u = 2^-53, and mx, my, mz, L are the largest |dx|, |dy|, |dz|, dx^2 + dy^2 + dz^2. Rounding changes a
// determinant of 6 products by at most 8u * 6 mx my mz, and one of 24 by 16u * 24 mx my mz L. (Shewchuk, Adaptive
// precision floating-point arithmetic and fast robust geometric predicates, 1997, has the same 7 and 16 per product.)
#pragma once

#include "exact/predicate.hpp"

namespace votess::exact {

// Returns the sign of det(a - d, b - d, c - d): +1 when a, b, c turn clockwise as seen from d. Coordinates below 2^90.
int orient(const Point& a, const Point& b, const Point& c, const Point& d);

// Returns +1 when p lies strictly inside the sphere through a, b, c, d, where orient(a, b, c, d) > 0; -1 outside, 0 on
// it.
int insphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& p);

// A vector, and bounds of the rounding errors of its components, 0 where they are exact. The largest component is from
// 1 to 2, and all are multiples of 2^-108: a wall may have this normal.
struct RoundedNormal {
    Point n{}, error{};
};
// Returns (b - a) x (c - a) divided by a positive number; 0 for collinear points. Small whole numbers stay exact: they
// are divided by their greatest common divisor.
RoundedNormal triangle_normal(const Point& a, const Point& b, const Point& c);

}  // namespace votess::exact

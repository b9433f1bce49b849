// The side of a vertex in sums of two doubles. It decides most signs that doubles leave open, for planes whose integers
// are wide: those of power diagrams.
//
// Cramer as in predicate.cpp: with E = Nd.V - Sd D, and A the sum of its terms' absolute values, E has its sign where
// |E| is above the bound on its error. With u = 2^-53 and exact differences, an error in units of u^2 times the
// absolute values of its terms (N: 0, S: 14.4, minors: 8.2, V: 33.9, D: 19.5) leaves |error of E| <= 48.3 u^2 A, by the
// bounds of double_double.hpp. Where no difference is above 2^150 nothing overflows, and all that underflows adds less
// than 2^-590.
#pragma once

#include "exact/predicate.hpp"

namespace votess::exact {

// Returns what side_of_vertex() does, or 0 if rounding hides it.
int side_in_pairs(const Point& p, const Plane& a, const Plane& b, const Plane& c, const Plane& d);

}  // namespace votess::exact

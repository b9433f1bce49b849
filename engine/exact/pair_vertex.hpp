// A vertex of planes a, b, c in sums of two doubles, tested against many planes d. It decides most signs that doubles
// leave open, for planes whose integers are wide: those of power diagrams.
//
// Cramer, E and A as in vertex.hpp. With u = 2^-53 and exact differences, an error in units of u^2 times the absolute
// values of its terms (N: 0, S: 14.4, minors: 8.2, V: 33.9, D: 19.5) leaves |error of E| <= 48.3 u^2 A, by the bounds
// of double_double.hpp. Where no difference is above 2^150 nothing overflows, and all that underflows adds less than
// 2^-590.
#pragma once

#include <array>

#include "exact/double_double.hpp"
#include "exact/predicate.hpp"

namespace votess::exact {

class PairVertex {
public:
    // a, b, c must meet in one point.
    PairVertex(const Point& p, const Plane& a, const Plane& b, const Plane& c);

    // Returns the side of d as ExactVertex does, or 0 if rounding hides it.
    [[nodiscard]] int side(const Plane& d) const;

private:
    // A plane: 2 N.X <= S. size_s: the absolute values of the terms of S.
    struct Row {
        std::array<DoubleDouble, 3> n{};
        DoubleDouble s;
        double size_s = 0;
    };
    struct Sized {  // with the absolute values of its terms
        DoubleDouble value;
        double size = 0;
    };

    [[nodiscard]] static bool write_row(const Point& p, const Plane& plane, Row& row);

    Point p_;
    int sign_ = 0;  // of D; 0 while unknown
    std::array<Sized, 3> v_{};
    Sized determinant_;
};

}  // namespace votess::exact

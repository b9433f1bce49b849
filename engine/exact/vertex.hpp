// The vertex of planes a, b, c, solved once and tested against many planes d.
//
// Cramer: X = V / (2 D) with V = Sa (Nb x Nc) + Sb (Nc x Na) + Sc (Na x Nb), D = Na.(Nb x Nc); X lies outside d when
//     E = Nd.V - Sd D   has the sign of D .
// All values are in units of a quantum that divides every difference, so they are integers. E is computed in double
// first, and beside it A, the same expression over absolute values. With u = 2^-53 and differences rounded once,
//     |error of E| <= 17 u A   (N: 1, S: 5, minors: 4, V: 12, D: 8; second order below u).
// Nothing underflows, because integers are 0 or at least 1. E is exact when A <= 2^52: each value that is not
// multiplied by 0 is then an integer below 2^53, and only differences above 2^53 are rounded. So a lattice with
// differences below about 2^9 quanta (36 * 2^46 < 2^52) never leaves double. Otherwise integers decide, computed on
// first need.
#pragma once

#include <optional>

#include "exact/integer/vertex.hpp"
#include "exact/pair_vertex.hpp"
#include "exact/predicate.hpp"

namespace votess::exact {

class ExactVertex {
public:
    // a, b, c must meet in one point.
    ExactVertex(const Point& p, const Plane& a, const Plane& b, const Plane& c);

    // Returns +1 when the vertex lies strictly outside d, -1 strictly inside, 0 on it, as side_of_vertex() does.
    int side(const Plane& d);

private:
    enum class State { unknown, known, too_wide };

    bool solve();                     // in double; false when the quantum does not divide the differences of a, b, c
    bool refine(const Plane& plane);  // makes the quantum divide the plane's differences; false beyond its range
    void solve_integers();
    int side_integers(const Plane& d);
    int side_of_wide(const Plane& d);  // for numbers that these integers do not hold

    Point p_;
    Plane a_, b_, c_;
    int exponent_ = 0;  // differences of a, b, c are below 2^exponent
    int quantum_ = 0;
    double unit_ = 0, per_unit_ = 0;  // 2^quantum, 2^-quantum
    bool usable_ = false;             // false: side_of_wide() decides
    int sign_ = 0;                    // of D; 0 while unknown
    double determinant_ = 0, determinant_bound_ = 0;
    std::array<double, 3> v_{}, v_bound_{};
    State state_ = State::unknown;
    IntVertex integers_;
    std::optional<PairVertex> pairs_;
};

}  // namespace votess::exact

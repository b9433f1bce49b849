// The one decision that everything follows from: is the vertex of planes a, b, c outside plane d?
//
// Planes are relative to a seed p. With integers N, S in units of a common power of two, a bisector with seed q is
//     2 N.X <= S,  N = q - p,  S = |N|^2        and a wall is        2 N.X <= S,  N = +-e_axis,  S = 2 (wall - p).N .
// Float64 coordinates are integers times a power of two, so the 4x4 determinant is decided in integer arithmetic
// without rounding, overflow or underflow for any float64 input; the width is chosen per call from the operands
// (64 bits when the differences fit 11, as in a lattice; 128 when they fit 24; 320 when they fit 60; wider beyond).
#pragma once

#include <array>

namespace votess::exact {

using Point = std::array<double, 3>;

// A plane as the input gives it.
struct Plane {
    enum class Kind { bisector, lower_wall, upper_wall };
    Kind kind = Kind::bisector;
    int axis = 0;  // walls
    Point seed{};  // bisector: coordinates of q
    double wall = 0;

    static Plane bisector(const Point& q) { return {Kind::bisector, 0, q, 0}; }
    static Plane lower(int axis, double at) { return {Kind::lower_wall, axis, {}, at}; }
    static Plane upper(int axis, double at) { return {Kind::upper_wall, axis, {}, at}; }
};

// +1 when the vertex lies strictly outside d, -1 strictly inside, 0 on it. a, b, c must meet in one point.
// For many d use ExactVertex (vertex.hpp).
int side_of_vertex(const Point& p, const Plane& a, const Plane& b, const Plane& c, const Plane& d);

// Sign of det(Na, Nb, Nc): +1 when the normals turn counterclockwise seen from outside.
int orientation(const Point& p, const Plane& a, const Plane& b, const Plane& c);

// The vertex relative to p and the difference q - p in a floating-point type: double, Quad or WideFloat
// (wide_float.hpp). Each component has a relative error of a few units in the last place, cancellation or not.
using Quad = __float128;
template <class Real>
std::array<Real, 3> vertex_position(const Point& p, const Plane& a, const Plane& b, const Plane& c);
template <class Real>
std::array<Real, 3> difference(const Point& q, const Point& p) {
    return {static_cast<Real>(q[0]) - static_cast<Real>(p[0]), static_cast<Real>(q[1]) - static_cast<Real>(p[1]),
            static_cast<Real>(q[2]) - static_cast<Real>(p[2])};
}

}  // namespace votess::exact

// The one decision that everything follows from: is the vertex of planes a, b, c outside plane d?
//
// Planes are relative to a seed p. With integers N, S in units of a common power of two, a bisector with seed q is
//     2 N.X <= S,  N = q - p,  S = |N|^2        and a wall is        2 N.X <= S,  N = +-e_axis,  S = 2 (wall - p).N .
// The seed of a bisector may be an image in a periodic box: q is then the exact sum of its coordinates and whole
// multiples of box vectors. In a power diagram S = |N|^2 + w_p - w_q. A wall of any direction n.x <= d has N = n and
// S = 2 (d - n.p), both times one power of two; the face of a triclinic box at its corner o, which two edges u and v
// span, has N = +-u x v and S = 2 N.(o - p), in the same way.
// Float64 coordinates are integers times a power of two, so the 4x4 determinant is decided in integer arithmetic
// without rounding, overflow or underflow for any float64 input; the width is chosen per call from the operands
// (64 bits when the differences fit 11, as in a lattice; 128 when they fit 24; 320 when they fit 60; wider beyond).
#pragma once

#include <array>
#include <cstdint>

#include "exact/double_double.hpp"

namespace votess::exact {

using Point = std::array<double, 3>;
using Shift = std::array<std::int32_t, 3>;

inline constexpr std::int32_t max_shift = 1 << 30;

// Vectors of a periodic box, each coordinate an exact sum of two doubles, because upper - lower need not be one; those
// of a triclinic box are doubles.
struct Lattice {
    std::array<std::array<DoubleDouble, 3>, 3> vector{};
    // A triclinic box with walls has here the cross products of the other two vectors, each rounded to two doubles.
    std::array<std::array<DoubleDouble, 3>, 3> across{};
};

// A plane as the input gives it.
struct Plane {
    enum class Kind : std::uint8_t { bisector, lower_wall, upper_wall, wall, cell_wall };
    Kind kind = Kind::bisector;
    int axis = 0;                      // lower_wall, upper_wall; cell_wall: the vector that is not in it
    Point seed{};                      // bisector: coordinates of q; wall: its normal, of order one; cell_wall: o
    double wall = 0;                   // where the wall is, or the offset d; cell_wall: the sign of N; reversed: -1
    Shift shift{};                     // bisector: added to q, cell_wall: to o, in vectors of the lattice
    const Lattice* lattice = nullptr;  // of a bisector null when shift is 0
    DoubleDouble power{};              // bisector: w_p - w_q, exact

    static Plane bisector(const Point& q) {
        Plane plane;
        plane.seed = q;
        return plane;
    }
    // The bisector with the image of q by a shift.
    static Plane bisector(const Point& q, const Shift& shift, const Lattice& lattice) {
        Plane plane = bisector(q);
        if (shift != Shift{}) plane.shift = shift, plane.lattice = &lattice;
        return plane;
    }
    static Plane lower(int axis, double at) { return box_wall(Kind::lower_wall, axis, at); }
    static Plane upper(int axis, double at) { return box_wall(Kind::upper_wall, axis, at); }
    static Plane box_wall(Kind kind, int axis, double at) {
        Plane plane;
        plane.kind = kind, plane.axis = axis, plane.wall = at;
        return plane;
    }
    // normal.x <= offset; no component of the normal is finer than 2^-lowest_normal_bit, none larger than 2.
    static Plane any_wall(const Point& normal, double offset) {
        Plane plane = bisector(normal);
        plane.kind = Kind::wall, plane.wall = offset;
        return plane;
    }
    static constexpr int lowest_normal_bit = 110;
    // A face of the triclinic box with that corner; sign: of the determinant of its vectors.
    static Plane cell_wall(int axis, bool upper, const Point& corner, const Lattice& lattice, double sign) {
        Plane plane = bisector(corner);
        plane.kind = Kind::cell_wall, plane.axis = axis, plane.wall = upper ? sign : -sign, plane.lattice = &lattice;
        if (upper) plane.shift[static_cast<std::size_t>(axis)] = 1;
        return plane;
    }

    [[nodiscard]] bool is_bisector() const { return kind == Kind::bisector; }
    // Returns N of a cell_wall; each component is rounded once.
    [[nodiscard]] Point rounded_normal() const {
        const auto& [x, y, z] = lattice->across[static_cast<std::size_t>(axis)];
        return {wall * x.high, wall * y.high, wall * z.high};
    }
    // A wall across no axis.
    [[nodiscard]] bool is_oblique() const { return kind == Kind::wall || kind == Kind::cell_wall; }
    // A bisector that keeps the side of q: N and S change their signs.
    [[nodiscard]] bool is_reversed() const { return is_bisector() && wall < 0; }
    void reverse() { wall = -1; }
    // Neither image nor power nor reversed nor an oblique wall: S follows from N or the axis.
    [[nodiscard]] bool plain() const { return lattice == nullptr && !has_power() && !is_reversed() && !is_oblique(); }
    [[nodiscard]] bool has_power() const { return power.high != 0; }
};

// q - p, whether the bisector is reversed or not. Each coordinate is an exact sum of two doubles, or rounded to 2^-104
// where that is impossible (`exact` is then false), or overflows (low is NaN).
struct Differences {
    std::array<DoubleDouble, 3> x;
    bool exact = true;
};
Differences image_differences(const Point& p, const Plane& bisector);
// Fills lattice.across from vectors that are doubles, none of whose products underflows.
void set_across(Lattice& lattice);
inline Differences differences(const Point& p, const Plane& bisector) {
    if (bisector.lattice != nullptr) return image_differences(p, bisector);
    const auto& q = bisector.seed;
    return {{two_sum(q[0], -p[0]), two_sum(q[1], -p[1]), two_sum(q[2], -p[2])}, true};
}

// +1 when the vertex lies strictly outside d, -1 strictly inside, 0 on it. a, b, c must meet in one point.
// For many d use ExactVertex (vertex.hpp).
int side_of_vertex(const Point& p, const Plane& a, const Plane& b, const Plane& c, const Plane& d);

// Sign of det(Na, Nb, Nc): +1 when the normals turn counterclockwise seen from outside.
int orientation(const Point& p, const Plane& a, const Plane& b, const Plane& c);

// Two bisectors of a power diagram: whether they are one plane, seen from the same side; then whether |Na| > |Nb|.
bool same_plane(const Point& p, const Plane& a, const Plane& b);
bool longer_normal(const Point& p, const Plane& a, const Plane& b);
// Bisectors whose power is less the weight of their seed: +1 when a's seed is farther from p than b's, by
// |q - p|^2 - w, -1 when it is nearer, 0 when they are equally far.
int farther(const Point& p, const Plane& a, const Plane& b);

// The vertex relative to p and the difference q - p in a floating-point type: double, Quad or WideFloat
// (wide_float.hpp). Each component has a relative error of a few units in the last place, cancellation or not.
template <class Real>
std::array<Real, 3> vertex_position(const Point& p, const Plane& a, const Plane& b, const Plane& c);
// q - p of a bisector.
template <class Real>
std::array<Real, 3> difference(const Point& p, const Plane& bisector);
// h of N.X = h on a plane that is no wall of a box: S / 2, whose terms may cancel, in the units of the coordinates and
// of N. N of a wall is its normal as given, of a cell_wall the cross product of the vectors.
template <class Real>
Real height(const Point& p, const Plane& plane);

}  // namespace votess::exact

// The decision on which every list rests: is the vertex of planes a, b, c outside plane d?
//
// Planes are relative to a seed p. N and S are integers in units of a common power of two.
//     bisector with seed q    2 N.X <= S,  N = q - p,  S = |N|^2; in a power diagram S = |N|^2 + w_p - w_q
//     wall of a box           2 N.X <= S,  N = +-e_axis,  S = 2 (wall - p).N
//     wall n.x <= d           N = n,  S = 2 (d - n.p), both times one power of two
//     face of a cell          N = +-u x v,  S = 2 N.(o - p), likewise: the edges u and v span it at the corner o
// In a periodic box q may be an image: the exact sum of the coordinates and whole multiples of box vectors.
//
// Float64 coordinates are integers times a power of two. So integer arithmetic decides the 4x4 determinant without
// rounding, overflow or underflow for any float64 input. The width follows from the operands of each call: 64 bits when
// the differences fit 11, as in a lattice; 128 when they fit 24; 320 when they fit 60; wider beyond.
#pragma once

#include <array>
#include <cstdint>

#include "exact/double_double.hpp"
#include "exact/quad.hpp"

namespace votess::exact {

using Point = std::array<double, 3>;
using Shift = std::array<std::int32_t, 3>;

inline constexpr std::int32_t max_shift = 1 << 30;

// Vectors of a periodic box. Each coordinate is an exact sum of two doubles, because upper - lower may not be a double.
// The vectors of a triclinic box are doubles.
struct Lattice {
    std::array<std::array<DoubleDouble, 3>, 3> vector{};
    // Filled for a triclinic box with walls: the cross products of the other two vectors, each rounded to two doubles.
    std::array<std::array<DoubleDouble, 3>, 3> across{};
};

// A plane as the input gives it.
struct Plane {
    enum class Kind : std::uint8_t { bisector, lower_wall, upper_wall, wall, cell_wall };
    Kind kind = Kind::bisector;
    int axis = 0;                      // lower_wall, upper_wall: across it; cell_wall: the vector that is not in it
    Point seed{};                      // bisector: coordinates of q; wall: its normal, of order one; cell_wall: o
    double wall = 0;                   // position of the wall, or the offset d; cell_wall: the sign of N; reversed: -1
    Shift shift{};                     // added to q (bisector) or o (cell_wall), in lattice vectors
    const Lattice* lattice = nullptr;  // null for a bisector whose shift is 0
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
    // The wall normal.x <= offset. No component of the normal is finer than 2^-lowest_normal_bit or larger than 2.
    static Plane any_wall(const Point& normal, double offset) {
        Plane plane = bisector(normal);
        plane.kind = Kind::wall, plane.wall = offset;
        return plane;
    }
    static constexpr int lowest_normal_bit = 110;
    // A face of the triclinic box with that corner. sign: of the determinant of the box vectors.
    static Plane cell_wall(int axis, bool upper, const Point& corner, const Lattice& lattice, double sign) {
        Plane plane = bisector(corner);
        plane.kind = Kind::cell_wall, plane.axis = axis, plane.wall = upper ? sign : -sign, plane.lattice = &lattice;
        if (upper) plane.shift[static_cast<std::size_t>(axis)] = 1;
        return plane;
    }

    [[nodiscard]] bool is_bisector() const { return kind == Kind::bisector; }
    // Returns N of a cell_wall, each component rounded once.
    [[nodiscard]] Point rounded_normal() const {
        const auto& [x, y, z] = lattice->across[static_cast<std::size_t>(axis)];
        return {wall * x.high, wall * y.high, wall * z.high};
    }
    // A wall across none of the axes.
    [[nodiscard]] bool is_oblique() const { return kind == Kind::wall || kind == Kind::cell_wall; }
    // A bisector that keeps the side of q: N and S have the opposite signs.
    [[nodiscard]] bool is_reversed() const { return is_bisector() && wall < 0; }
    void reverse() { wall = -1; }
    // True if S follows from N or the axis: not an image, a power, reversed or an oblique wall.
    [[nodiscard]] bool plain() const { return lattice == nullptr && !has_power() && !is_reversed() && !is_oblique(); }
    [[nodiscard]] bool has_power() const { return power.high != 0; }
};

// q - p, for reversed bisectors too. Each coordinate is an exact sum of two doubles. If that is impossible it is
// rounded to 2^-104 and `exact` is false; if it overflows, low is NaN.
struct Differences {
    std::array<DoubleDouble, 3> x;
    bool exact = true;
};
Differences image_differences(const Point& p, const Plane& bisector);
// Fills lattice.across. The vectors must be doubles, and none of their products may underflow.
void set_across(Lattice& lattice);
inline Differences differences(const Point& p, const Plane& bisector) {
    if (bisector.lattice != nullptr) return image_differences(p, bisector);
    const auto& q = bisector.seed;
    return {{two_sum(q[0], -p[0]), two_sum(q[1], -p[1]), two_sum(q[2], -p[2])}, true};
}

// Returns +1 when the vertex lies strictly outside d, -1 strictly inside, 0 on it. a, b, c must meet in one point.
int side_of_vertex(const Point& p, const Plane& a, const Plane& b, const Plane& c, const Plane& d);

// Returns the sign of det(Na, Nb, Nc): +1 when the normals turn counterclockwise seen from outside.
int orientation(const Point& p, const Plane& a, const Plane& b, const Plane& c);

// For two bisectors of a power diagram: whether they are one plane with the same side, and whether |Na| > |Nb|.
bool same_plane(const Point& p, const Plane& a, const Plane& b);
bool longer_normal(const Point& p, const Plane& a, const Plane& b);
// For bisectors whose power is minus the weight of their seed: compares |q - p|^2 - w. Returns +1 when a's seed is
// farther from p than b's, -1 when it is nearer, 0 when they are equally far.
int farther(const Point& p, const Plane& a, const Plane& b);

// Returns the vertex relative to p in a floating-point type: double, Quad (quad.hpp) or WideFloat. Each component
// has a relative error of a few units in the last place, whatever cancels.
template <class Real>
std::array<Real, 3> vertex_position(const Point& p, const Plane& a, const Plane& b, const Plane& c);
// Returns the same vertex, wrong by at most 2^-52 of its length. Takes a tenth of the time if the planes are not very
// nearly parallel.
Point near_vertex(const Point& p, const Plane& a, const Plane& b, const Plane& c);
// Returns q - p of a bisector, as accurately as vertex_position().
template <class Real>
std::array<Real, 3> difference(const Point& p, const Plane& bisector);
// Returns 2^exponent times h of N.X = h, that is S / 2, in the units of the coordinates and of N; not for walls of a
// box. N of a wall is its normal as given, N of a cell_wall the cross product of the vectors.
template <class Real>
Real height(const Point& p, const Plane& plane, int exponent);

}  // namespace votess::exact

// Where cells live: a box or a triclinic box, each periodic along any of its edges and with walls across the others, or
// a box cut by more walls. Lengths are those of the job, times its scale.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "exact/predicate.hpp"
#include "votess/votess.hpp"

namespace votess {

// Three vectors that span the lattice of a periodic domain; along axes that are not periodic, the edges of its box, or
// of reduced vectors those parts of them that stand straight on the lattice.
struct Basis {
    std::array<exact::Shift, 3> shift{};            // in vectors of the lattice; zero along other axes
    std::array<std::array<double, 3>, 3> vector{};  // rounded
    std::array<std::array<double, 3>, 3> low{};     // what rounding took from them; known of reduced vectors alone
    std::array<std::array<double, 3>, 3> dual{};    // x = f.vector with f_j = dual[j].x
    std::array<double, 3> width{};                  // between planes of whole f_j
    double condition = 1;                           // product of the lengths over the volume
    double volume = 0;

    [[nodiscard]] std::array<double, 3> fraction(const std::array<double, 3>& x) const;
    // At least the error of a fraction of x - origin, when no coordinate of x and origin is larger than `size` and x is
    // rounded.
    [[nodiscard]] double fraction_error(int j, double size) const;
};

// Shifts a.reduced with lower <= a <= upper on each axis.
struct ShiftRange {
    std::array<std::int32_t, 3> lower{}, upper{};

    [[nodiscard]] bool is_single() const { return lower == upper; }
    friend bool operator==(const ShiftRange&, const ShiftRange&) = default;
};

struct Domain {
    Box box;  // its walls, where an axis is not periodic; of a triclinic box the bounds
    std::array<bool, 3> periodic{};
    double volume = 0;
    std::vector<exact::Plane> walls;  // ids -7, -8, ... in this order

    bool triclinic = false;
    exact::Point origin{};
    exact::Lattice lattice;                         // of a box zero along axes that are not periodic
    std::array<std::array<double, 3>, 3> vector{};  // the same, rounded
    double handedness = 1;                          // sign of the determinant of the vectors
    Basis edges;    // the points of the domain are origin + f.edges, with 0 <= f < 1 along periodic axes
    Basis reduced;  // short vectors of the same lattice
    // The cell is so flat beside its reduced one that seeds are better moved into that.
    bool skewed = false;
    double covering_radius = 0;  // at least the largest distance of a point of space to the nearest image of a seed

    // Power diagrams: by input index, times scale squared; else empty.
    std::vector<double> weights;
    double min_weight = 0, largest_weight = 0;  // of the seeds inside

    [[nodiscard]] bool is_periodic() const { return periodic[0] || periodic[1] || periodic[2]; }
    [[nodiscard]] bool has_weights() const { return !weights.empty(); }
    // A box with walls and no weights.
    [[nodiscard]] bool is_plain() const { return !is_periodic() && !triclinic && walls.empty() && !has_weights(); }
    // By how much the weight of a seed that matters to a cell may exceed the cell's.
    [[nodiscard]] double max_heavier_by(double weight) const;
    // Returns where a place lies along the edges: 0 to 1 inside the domain.
    [[nodiscard]] std::array<double, 3> fraction(const exact::Point& x) const {
        return edges.fraction({x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]});
    }
    [[nodiscard]] exact::Point translation(const exact::Shift& shift) const;  // each coordinate to nearest
    // Walls of the box count from 0, xmin to zmax.
    [[nodiscard]] bool has_box_wall(int wall) const { return !periodic[wall / 2]; }
    // Whether there are walls of the box that are not across x, y or z.
    [[nodiscard]] bool has_cell_walls() const { return triclinic && !(periodic[0] && periodic[1] && periodic[2]); }
    // A wall of the box, which refers to this domain.
    [[nodiscard]] exact::Plane box_wall(int wall) const;
};

// The shifts by which an image of a point may bound the point's own cell: by -2 to 2 of each of the reduced vectors, of
// which any two are short beside each other. The nearest come first.
std::vector<exact::Shift> near_translations(const Domain& domain);
// At most the distance of a point to its nearest image; infinite where nothing repeats.
double nearest_translation(const Domain& domain);
// The shifts by which a point of `box` may come nearer than `distance` to x, with care for rounding. Where there are
// none, only that by 0.
ShiftRange shifts_around(const Domain& domain, const Box& box, const exact::Point& x, double distance);
// Bounds of all images of the points of `box` by shifts of the range, as seen from x, rounded outward once.
Box images_of(const Domain& domain, const Box& box, const ShiftRange& range, const exact::Point& x);
std::array<ShiftRange, 2> halves(const ShiftRange& range, int axis);
// The axis along which the images of a point by the range extend farthest, and how far.
struct Extent {
    int axis = 0;
    double length = 0;
};
Extent longest_extent(const Domain& domain, const ShiftRange& range);
// The shift of a range that holds one.
exact::Shift only_shift(const Domain& domain, const ShiftRange& range);

double largest_coordinate(const Box& box);

// Domain of a box; the periods along its periodic axes are upper - lower, exactly.
Domain box_domain(const Box& box, const std::array<bool, 3>& periodic);
// Throws Error(invalid_argument) when the vectors span no volume that floating point can tell from 0. Its largest
// number is of order one.
Domain triclinic_domain(const TriclinicBox& cell);
// Whether x lies between the walls of a triclinic box, or on them, exactly.
bool inside_walls(const Domain& domain, const exact::Point& x);

// The shift that brings x into a periodic domain: without rounding, so that images of a point are brought to the same.
// Returns nothing when that is more than some 500 million periods.
std::optional<exact::Shift> wrap(const Domain& domain, const exact::Point& x);
// The shift that brings a point of a skewed domain into its reduced cell, or, by rounding, just beside it.
exact::Shift shift_into_reduced(const Domain& domain, const exact::Point& x);

// A wall normal . x <= offset, with a normal of order one and the offset times scale. Throws Error(invalid_argument),
// which calls it `name`.
exact::Plane domain_wall(const Wall& wall, double scale, const std::string& name);
// Whether x fulfils wall.normal . x <= wall.offset, exactly.
bool inside(const exact::Plane& wall, const exact::Point& x);

}  // namespace votess

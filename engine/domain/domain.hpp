// The domain of a job: a box or a triclinic box, periodic along any of its edges, with walls across the others and
// further walls. Lengths are multiplied by the scale of the job.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "domain/wall_tree.hpp"
#include "exact/predicate.hpp"
#include "votess/votess.hpp"

namespace votess {

// Three vectors that span the lattice of a periodic domain. Along other axes they are the edges of the box; in a
// reduced basis, the parts of those edges that are perpendicular to the lattice.
struct Basis {
    std::array<exact::Shift, 3> shift{};            // in vectors of the lattice; zero along other axes
    std::array<std::array<double, 3>, 3> vector{};  // rounded
    std::array<std::array<double, 3>, 3> low{};     // rounding errors of vector; filled for reduced vectors only
    std::array<std::array<double, 3>, 3> dual{};    // x = f.vector with f_j = dual[j].x
    std::array<double, 3> width{};                  // between planes of whole f_j
    double condition = 1;                           // product of the lengths over the volume
    double volume = 0;

    [[nodiscard]] std::array<double, 3> fraction(const std::array<double, 3>& x) const;
    // Returns a bound on the error of a fraction of x - origin. x is rounded, and no coordinate of x and origin exceeds
    // `size`.
    [[nodiscard]] double fraction_error(int j, double size) const;
};

// Shifts a.reduced with lower <= a <= upper on each axis.
struct ShiftRange {
    std::array<std::int32_t, 3> lower{}, upper{};

    [[nodiscard]] bool is_single() const { return lower == upper; }
    friend bool operator==(const ShiftRange&, const ShiftRange&) = default;
};

struct Domain {
    Box box;  // walls along axes that are not periodic; bounds of a triclinic box
    std::array<bool, 3> periodic{};
    double volume = 0;
    std::vector<exact::Plane> walls;  // ids -7, -8, ... in this order
    WallTree wall_tree;               // of many walls, else empty
    // With walls: ids of those that bound the domain, of the box too, and a place well inside. Empty if nothing is
    // inside.
    std::vector<std::int32_t> facets;
    exact::Point middle{};
    bool seeds_beyond = false;  // some seeds of the job lie beyond walls

    bool triclinic = false;
    exact::Point origin{};
    exact::Lattice lattice;  // zero along axes of a box that are not periodic
    std::array<std::array<double, 3>, 3> vector{};
    double handedness = 1;  // sign of the determinant of the vectors
    Basis edges;            // points of the domain are origin + f.edges, with 0 <= f < 1 along periodic axes
    Basis reduced;          // short vectors of the same lattice
    // The cell is so flat that seeds are moved into the reduced one.
    bool skewed = false;
    double covering_radius = 0;  // bound on the distance of any point to the nearest image of a seed

    // Weights of a power diagram, by input index, times scale squared; else empty.
    std::vector<double> weights;
    double min_weight = 0, largest_weight = 0;  // of the seeds inside

    [[nodiscard]] bool is_periodic() const { return periodic[0] || periodic[1] || periodic[2]; }
    [[nodiscard]] bool has_weights() const { return !weights.empty(); }
    // Returns how much the weight of a seed that matters to a cell may exceed the cell's weight.
    [[nodiscard]] double max_heavier_by(double weight) const;
    // Returns the coordinates along the edges: 0 to 1 inside the domain.
    [[nodiscard]] std::array<double, 3> fraction(const exact::Point& x) const {
        return edges.fraction({x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]});
    }
    [[nodiscard]] exact::Point translation(const exact::Shift& shift) const;  // each coordinate to nearest
    // Walls of the box are 0 to 5, xmin to zmax.
    [[nodiscard]] bool has_box_wall(int wall) const { return !periodic[wall / 2]; }
    // Whether the box has walls that are not across x, y or z.
    [[nodiscard]] bool has_cell_walls() const { return triclinic && !(periodic[0] && periodic[1] && periodic[2]); }
    // Refers to this domain.
    [[nodiscard]] exact::Plane box_wall(int wall) const;
};

// Returns the shifts by which an image of a point may bound the point's own cell, nearest first. These are -2 to 2
// times each reduced vector, because any two of them are short compared with each other.
std::vector<exact::Shift> near_translations(const Domain& domain);
// Returns a lower bound of the distance from a point to its nearest image; infinite if nothing repeats.
double nearest_translation(const Domain& domain);
// Returns the shifts by which a point of `box` may come nearer than `distance` to x, allowing for rounding; only shift
// 0 if there are none.
ShiftRange shifts_around(const Domain& domain, const Box& box, const exact::Point& x, double distance);
// Returns the bounds of all images of the points of `box` by shifts of the range, as seen from x, rounded outward once.
Box images_of(const Domain& domain, const Box& box, const ShiftRange& range, const exact::Point& x);
std::array<ShiftRange, 2> halves(const ShiftRange& range, int axis);
// The axis along which the images of a point by a range extend farthest.
struct Extent {
    int axis = 0;
    double length = 0;
};
Extent longest_extent(const Domain& domain, const ShiftRange& range);
exact::Shift only_shift(const Domain& domain, const ShiftRange& range);

double largest_coordinate(const Box& box);
// Returns the power of two that brings the largest number of the domain to order one; 1 if it is ordinary already.
double scale_for(double largest);

// Makes wall_tree, if it is worth it, when walls and box are complete.
void sort_walls(Domain& domain);

// Returns the domain of a box. Its periods are upper - lower, exactly.
Domain box_domain(const Box& box, const std::array<bool, 3>& periodic);
// Throws Error(invalid_argument) when the volume of the vectors is 0 to rounding. The largest number of the box must be
// of order one.
Domain triclinic_domain(const TriclinicBox& cell);
// Exact. A place on a wall is inside.
bool inside_walls(const Domain& domain, const exact::Point& x);

// Returns the shift that brings x into a periodic domain, or nothing when that takes more than some 500 million
// periods. Exact, so images of a point are brought to the same point.
std::optional<exact::Shift> wrap(const Domain& domain, const exact::Point& x);
// To rounding.
exact::Shift shift_into_reduced(const Domain& domain, const exact::Point& x);

// Returns a wall normal.x <= offset, with a normal of order one and the offset times scale. Errors call it `name`.
// Throws Error(invalid_argument).
exact::Plane domain_wall(const Wall& wall, double scale, const std::string& name);
// Whether normal.x <= offset holds. Exact.
bool inside(const exact::Plane& wall, const exact::Point& x);

}  // namespace votess

// Where cells live: a box, periodic or with walls, a triclinic periodic box, or a box cut by more walls. Lengths are
// those of the job, times its scale.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "exact/predicate.hpp"
#include "votess/votess.hpp"

namespace votess {

struct Domain {
    Box box;  // its walls, where an axis is not periodic; of a triclinic box the bounds
    std::array<bool, 3> periodic{};
    double volume = 0;
    std::vector<exact::Plane> walls;  // ids -7, -8, ... in this order

    // Periodic domains: its points are origin + f.vectors, with 0 <= f < 1 along periodic axes.
    bool triclinic = false;
    exact::Point origin{};
    exact::Lattice lattice;                              // zero along axes that are not periodic
    std::array<std::array<double, 3>, 3> vector{};       // the same, rounded
    std::array<std::array<double, 3>, 3> to_fraction{};  // f_j = to_fraction[j].(x - origin)
    std::array<double, 3> width{};                       // between opposite faces
    // Short vectors of the lattice that span it, in whole multiples of its vectors; of periodic axes only.
    std::array<exact::Shift, 3> short_vectors{};
    std::array<std::array<double, 3>, 3> to_short{};  // x = k.short_vectors with k_j = to_short[j].x
    std::array<double, 3> short_width{};              // between planes of whole k_j
    // The domain in that basis, from its origin.
    std::array<double, 3> short_lower{}, short_upper{};
    double covering_radius = 0;  // at least the largest distance of a point of space to the nearest image of a seed

    // Power diagrams: by input index, times scale squared; else empty.
    std::vector<double> weights;
    double largest_weight = 0;

    [[nodiscard]] bool is_periodic() const { return periodic[0] || periodic[1] || periodic[2]; }
    [[nodiscard]] bool has_weights() const { return !weights.empty(); }
    // A box with walls and no weights.
    [[nodiscard]] bool is_plain() const { return !is_periodic() && walls.empty() && !has_weights(); }
    [[nodiscard]] std::array<double, 3> fraction(const exact::Point& x) const;
    [[nodiscard]] exact::Point translation(const exact::Shift& shift) const;  // rounded
    // All shifts, nearest first, by which some point of a periodic domain may come nearer than that to x, which lies in
    // it; 0 among them.
    [[nodiscard]] std::vector<exact::Shift> shifts_within(const exact::Point& x, double distance) const;
    // Walls of the box count from 0, xmin to zmax.
    [[nodiscard]] bool has_box_wall(int wall) const { return !periodic[wall / 2]; }
};

double largest_coordinate(const Box& box);

// Domain of a box; the periods along its periodic axes are upper - lower, exactly.
Domain box_domain(const Box& box, const std::array<bool, 3>& periodic);
// Throws Error(invalid_argument) when the vectors span no volume that floating point can tell from 0. Its largest
// number is of order one.
Domain triclinic_domain(const TriclinicBox& cell);

// The shift that brings x into a periodic domain: without rounding, so that images of a point are brought to the same.
// Nothing when that is more than some 500 million periods.
std::optional<exact::Shift> wrap(const Domain& domain, const exact::Point& x);

// A wall normal . x <= offset, with a normal of order one and the offset times scale. Throws Error(invalid_argument),
// which calls it `name`.
exact::Plane domain_wall(const Wall& wall, double scale, const std::string& name);
// Whether x fulfils wall.normal . x <= wall.offset, exactly.
bool inside(const exact::Plane& wall, const exact::Point& x);
// Bounds of where all walls leave room, moved out by a little; those of `otherwise` where the walls leave room without
// bounds, which is what lies beyond a million times the size of `otherwise`, or none at all.
Box bounds_of(const std::vector<Wall>& walls, const Box& otherwise);

}  // namespace votess

// Domains without end: some or all bounds of the box are infinite, or edges of the cell are 0. A run makes cells in a
// finite domain instead, with its own walls on the sides without end.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vector3.hpp"
#include "input/job.hpp"

namespace votess {

// Returns the axis that each pair of sides at infinity lies across, -1 for sides that have ends. An edge of a cell that
// is 0 stands for the axis that is most nearly perpendicular to the other edges.
[[nodiscard]] std::array<int, 3> endless_axes(const Region& region);

// Moves sides without end to two places along their axis. Across an edge of a cell they are the planes of the other
// edges through these places. pair: of sides, or the edge.
void set_ends(Region& region, std::size_t pair, int axis, double lower, double upper);

// The edges of a domain, with axes in place of those without end, and places along them: coordinates in a box. In a
// cell places are rounded.
class Edges {
public:
    explicit Edges(const Region& region);

    // The domain as given.
    [[nodiscard]] const Region& region() const { return region_; }
    // Returns its ends along the edges, and where it has none those given here.
    [[nodiscard]] Box ends_or(const Box& others) const;
    // Returns the domain with these ends where it has none.
    [[nodiscard]] Region with_ends(const Box& ends) const;
    [[nodiscard]] Vector3 along(const Vector3& x) const;

    [[nodiscard]] bool is_periodic() const { return !lattice_.empty(); }
    [[nodiscard]] bool has_walls() const { return has_walls_; }  // of a cell
    // All numbers that the differences of images depend on, beside the seeds.
    [[nodiscard]] const std::vector<double>& numbers() const { return numbers_; }
    // The sum of the lengths of the periods, and of other edges of a cell.
    [[nodiscard]] double longest_sum() const { return longest_sum_; }
    // Returns the part of x across the lattice.
    [[nodiscard]] Vector3 across(Vector3 x) const;

private:
    Region region_;
    std::array<int, 3> axes_;
    Vector3 origin_{};  // of a cell; 0 along axes without end
    std::array<Vector3, 3> dual_{};
    Vector3 lengths_{};
    std::vector<Vector3> lattice_;  // orthonormal
    std::vector<double> numbers_;
    double longest_sum_ = 0;
    bool has_walls_ = false;
};

// Gives all sides ends that are farther than the points by six times the longest side of their bounds, or the longest
// period. Nearly all cells of many points end within it. Returns the ends along the edges.
Box end_near(Region& region, const Points& points, const Weights& weights = {});

// Gives all sides ends beyond all vertices of the diagram of these points and of any subset. Vertices on walls of sides
// that have ends are among them.
//
// A vertex x is the solution of A x = b with the differences of neighbors as rows of A: x = adj(A) b / det A. Let all
// coordinates be multiples of u, S the largest difference, and w the largest difference of weights. Then |det A| >=
// u^3, and |x| <= 13.5 S (S/u)^3 (1 + w/S^2) from a seed. Throws `unsupported` where that is too large for a double.
//
// In a periodic domain rows are differences of images. They are multiples of the common unit u of coordinates and
// periods. Each cell lies between the bisectors of its seed and that seed's own images, whose weight is the same. So
// along the lattice it reaches no farther from its seed than half the sum of the periods, and neighbors are apart by
// the sum at most. Across the lattice they are apart by no more than the seeds.
//
// Walls of a cell are rows n x = n y, where the normal n is the product of an edge and an axis, or of edges. It is a
// multiple of u or u^2, no longer than S or S^2, and y is within S. So b is at most twice as large.
Box end_far(Region& region, const Points& points, const Weights& weights = {});

}  // namespace votess

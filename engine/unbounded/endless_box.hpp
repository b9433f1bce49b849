// Domains without end: some or all bounds of the box are infinite, or edges of the cell are 0. A run makes cells in a
// finite domain instead, with its own walls on the sides without end.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "input/job.hpp"

namespace votess {

// The sides of a domain that are at infinity.
class EndlessSides {
public:
    EndlessSides() = default;  // none
    // Throws invalid_argument for bounds of a box at the wrong infinity.
    explicit EndlessSides(const Options& options);

    [[nodiscard]] bool any() const { return sides_ != 0; }
    // Whether the wall of this id is at infinity. Those below -6 are FlatEnds.
    [[nodiscard]] bool has(std::int32_t id) const { return id < -6 || (id < 0 && (sides_ >> (-1 - id) & 1) != 0); }
    // Whether one of the walls of these ids is at infinity.
    [[nodiscard]] bool any_of(std::span<const std::int32_t> ids) const;
    // The id of infinity in rows: of the sides that are there, the one nearest to -1.
    [[nodiscard]] std::int32_t id() const;

private:
    unsigned sides_ = 0;
};

// Returns the axis that each pair of sides at infinity lies across, -1 for sides that have ends. An edge of a cell that
// is 0 stands for the axis that is most nearly perpendicular to the other edges.
[[nodiscard]] std::array<int, 3> endless_axes(const Options& options);

// Moves sides without end to two places along their axis. Across an edge of a cell they are the planes of the other
// edges through these places. pair: of sides, or the edge.
void set_ends(Options& options, std::size_t pair, int axis, double lower, double upper);

// Returns the weights, or the squares of the radii.
[[nodiscard]] std::vector<double> weights_of(const Options& options);

// Returns options without a domain, for checks of the others.
[[nodiscard]] Options without_domain(Options options);

// Refuses options that need a domain with ends.
void check_endless(const Options& options);

// Gives all sides ends that are farther than the points by six times the longest side of their bounds, or the longest
// period. Nearly all cells of many points end within it. The weights are those of the options.
void end_near(Options& options, const Points& points);

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
void end_far(Options& options, const Points& points);

}  // namespace votess

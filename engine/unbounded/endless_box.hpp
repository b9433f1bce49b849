// Boxes without end: some or all bounds are infinite. A run makes cells in a finite box instead, with its own walls on
// the sides without end.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "input/job.hpp"

namespace votess {

// The sides of a box that are at infinity.
class EndlessSides {
public:
    // Throws invalid_argument for bounds that are not numbers or at the wrong infinity.
    explicit EndlessSides(const std::optional<Box>& box);

    [[nodiscard]] bool any() const { return sides_ != 0; }
    // Whether the wall of this id is at infinity. Those below -6 are FlatEnds.
    [[nodiscard]] bool has(std::int32_t id) const { return id < -6 || (id < 0 && (sides_ >> (-1 - id) & 1) != 0); }
    // The id of infinity in rows: of the sides that are there, the one nearest to -1.
    [[nodiscard]] std::int32_t id() const;
    // Whether a side of this axis has an end.
    [[nodiscard]] bool has_end(std::size_t axis) const { return (sides_ >> 2 * axis & 3) != 3; }

private:
    unsigned sides_ = 0;
};

// Returns the weights, or the squares of the radii.
[[nodiscard]] std::vector<double> weights_of(const Options& options);

// Refuses options that need a domain with ends.
void check_endless(const Options& options);

// Returns `box` with ends on all sides: farther than the points by six times the longest side of their bounds. Nearly
// all cells of many points end within it.
[[nodiscard]] Box near_box(const Points& points, std::span<const double> weights, const Box& box);

// Returns `box` with ends on all sides, beyond all vertices of the diagram of these points and of any subset. Vertices
// on walls of sides that have ends are among them.
//
// A vertex x is the solution of A x = b with the differences of seeds as rows of A: x = adj(A) b / det A. Let all
// coordinates be multiples of u, S the largest difference, and w the largest difference of weights. Then |det A| >=
// u^3, and |x| <= 13.5 S (S/u)^3 (1 + w/S^2) from a seed. Throws `unsupported` where that is too large for a double.
[[nodiscard]] Box far_box(const Points& points, std::span<const double> weights, const Box& box);

}  // namespace votess

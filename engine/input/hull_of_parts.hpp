// Walls around the convex hull of points that come in parts. They depend on the corners of the hull alone. So they are
// the same for any parts, and for the corners of each part in place of its points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "input/region.hpp"
#include "votess/votess.hpp"

namespace votess {

class VOTESS_API HullOfParts {
public:
    // Throws invalid_argument if another domain is given. Its number of dimensions counts.
    explicit HullOfParts(const Region& given);

    // points: (n, 3), in the plane (n, 2).
    void add(std::span<const double> points);
    // Returns the corners so far, in ascending order. They are all points while these have no hull with an interior.
    // Throws invalid_argument for a point that is not finite.
    [[nodiscard]] const std::vector<double>& corners();
    // Returns a wall for each facet. Throws invalid_argument when the hull has no interior. count: of all points.
    [[nodiscard]] std::vector<Wall> walls(std::uint64_t count);

private:
    bool planar_;
    std::size_t dimensions_;
    std::uint64_t added_ = 0;
    std::vector<double> points_;  // the corners of earlier points, then those that came later
    std::size_t known_ = 0;       // coordinates of these corners
};

}  // namespace votess

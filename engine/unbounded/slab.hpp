// Seeds in one plane or on one line. Their diagram does not change along the normals, and neither do the walls of the
// domain. So two ends across each normal leave the whole diagram between them, wherever they are and however they are
// rounded, if they are parallel. In a thin slab the cells are as compact as in a box.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "input/job.hpp"

namespace votess {

class Slab {
public:
    // No ends if the seeds span space, or if a wall of the box with infinite bounds is not along the normals.
    Slab(const Points& points, const Box& box);

    [[nodiscard]] bool any() const { return !walls_.empty() || thin_ != std::array<bool, 3>{}; }
    // Whether a wall of a run in the slab is one of its ends.
    [[nodiscard]] bool has(std::int32_t id) const {
        return id <= -7 || (id < 0 && thin_[static_cast<std::size_t>((-1 - id) / 2)]);
    }
    // Sets the ends in options with a box.
    void cut(Options& options) const;

private:
    std::array<bool, 3> thin_{};  // axes across which a normal lies: the sides of the box are the ends
    Box sides_;
    std::vector<Wall> walls_;  // across other normals
};

}  // namespace votess

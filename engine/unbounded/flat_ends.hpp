// Ends of a domain without end, for seeds in one plane or on one line. Along the normals their diagram does not change,
// nor does the domain. So two parallel ends across each normal leave the whole diagram between them, wherever they are
// and however their direction is rounded. If they are close, cells are as compact as in a box.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "input/job.hpp"

namespace votess {

class FlatEnds {
public:
    // No ends if the seeds span space, or if a wall of the box with infinite bounds is not along the normals.
    FlatEnds(const Points& points, const Box& box);

    // Whether the wall of this id is one of them, in a run with cut() options.
    [[nodiscard]] bool has(std::int32_t id) const {
        return id <= -7 || (id < 0 && thin_[static_cast<std::size_t>((-1 - id) / 2)]);
    }
    // Adds the ends to options with a box.
    void cut(Options& options) const;

private:
    std::array<bool, 3> thin_{};  // axes across which a normal lies: the sides of the box are the ends
    Box sides_;
    std::vector<Wall> walls_;  // across other normals
};

}  // namespace votess

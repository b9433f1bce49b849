// Ends of a domain without end, for seeds in one plane or on one line, with all of their images. Along the normals
// their diagram does not change, nor does the domain. So two parallel ends across each normal leave the whole diagram
// between them, wherever they are and however their direction is rounded. If they are close, cells are as compact as in
// a box.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "input/job.hpp"

namespace votess {

class FlatEnds {
public:
    // No ends if the seeds span space, and none across a normal that is not along all walls of the domain. In a
    // periodic domain only those across axes; none where the lattice has parts along more axes than it has dimensions.
    FlatEnds(const Points& points, const Options& options);

    // Whether the wall of this id is one of them, in a run with cut() options.
    [[nodiscard]] bool has(std::int32_t id) const {
        return id <= -7 || (id < 0 && thin_[static_cast<std::size_t>((-1 - id) / 2)]);
    }
    // Adds the ends to options with a box.
    void cut(Options& options) const;

private:
    // Returns the pair of sides without end across an axis, or -1.
    [[nodiscard]] int pair_of(int axis) const;

    std::array<bool, 3> thin_{};  // pairs of sides across a normal along an axis: these are the ends
    std::array<int, 3> axes_{};   // of these sides
    Box sides_;                   // by axis
    std::vector<Wall> walls_;     // across other normals
};

}  // namespace votess

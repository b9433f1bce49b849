// Ends of a domain without end, for seeds in one plane or on one line, with all of their images. Along the normals
// their diagram does not change, nor does the domain. So two parallel ends across each normal leave the whole diagram
// between them, wherever they are and however their direction is rounded. If they are close, cells are as compact as in
// a box.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/vector3.hpp"
#include "exact/insphere.hpp"
#include "input/job.hpp"

namespace votess {

class FlatEnds {
public:
    // No ends if the seeds span space, and none across a normal that is not along all walls of the domain. In a
    // periodic domain only those across axes; none where the lattice has parts along more axes than it has dimensions.
    FlatEnds(const Points& points, const Region& region);

    // Whether the wall of this id is one of them, in a run in a region that was cut().
    [[nodiscard]] bool has(std::int32_t id) const {
        return id <= -7 || (id < 0 && thin_[static_cast<std::size_t>((-1 - id) / 2)]);
    }
    // Whether there are any ends.
    [[nodiscard]] bool any() const { return !planes_.empty(); }
    // Whether the diagram with a seed there has these ends too. Returns false for places far from the seeds.
    [[nodiscard]] bool holds(const Vector3& x) const;
    // Adds the ends to a region with a box.
    void cut(Region& region) const;

private:
    // The plane of the seeds across a normal.
    struct FlatPlane {
        exact::RoundedNormal normal;
        std::array<exact::Point, 3> points;
    };
    // Returns the pair of sides without end across an axis, or -1.
    [[nodiscard]] int pair_of(int axis) const;

    std::vector<FlatPlane> planes_;
    double scale_ = 1;               // of their points
    double farthest_ = 0;            // coordinate, times the scale, of places that they hold
    std::array<bool, 3> ignored_{};  // axes along a lattice
    std::array<bool, 3> thin_{};     // pairs of sides across a normal along an axis: these are the ends
    std::array<int, 3> axes_{};      // of these sides
    Box sides_;                      // by axis
    std::vector<Wall> walls_;        // across other normals
};

}  // namespace votess

// Inputs of the plane from those of space.
#pragma once

#include "support/generators.hpp"

namespace test {

// Returns x and y of the points and of the box.
inline PointSet in_plane(PointSet set) {
    for (std::size_t i = 0; i < set.points.size() / 3 * 2; ++i) set.points[i] = set.points[i / 2 * 3 + i % 2];
    set.points.resize(set.points.size() / 3 * 2);
    if (set.box) set.box->lower[2] = set.box->upper[2] = 0;
    return set;
}

}  // namespace test

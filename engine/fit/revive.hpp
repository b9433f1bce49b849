// Weights for cells that a step leaves empty.
#pragma once

#include <span>

#include "fit/laplacian.hpp"

namespace votess::fit {

struct Revival {
    std::span<const double> places;  // 3N, inside a periodic domain
    const Edges& edges;              // of the domain
    const Vector& targets;           // N volumes
    const Tessellation& before;      // the step; its neighbors are used
    const Tessellation& after;       // with neighbors and centroids
    const Vector& least;             // N volumes; a smaller cell is revived
};

// Raises the weight of each small cell. With the largest of these weights its cell touches the centroid of another,
// near its neighbors before, and takes about half of it. A cell with a smaller target gets less, but more in each try.
void revive(const Revival& cells, int attempt, Vector& weights);

}  // namespace votess::fit

// Weights for cells that a step leaves empty.
#pragma once

#include <span>

#include "fit/laplacian.hpp"

namespace votess::fit {

struct Revival {
    std::span<const double> places;     // 3N, inside a periodic domain
    const Edges& edges;                 // of the domain
    const Vector& targets;              // N volumes
    const Tessellation& before;         // the step; its neighbors are used
    const Tessellation& after;          // with neighbors
    const Vector& volumes;              // N, after
    std::span<const double> centroids;  // 3N, after; in cells that are not small
    const Vector& least;                // N volumes; a smaller cell is revived
    int dimensions = 3;                 // see Problem
};

// Raises the weight of each small cell, at most until it touches the centroid of a cell near its neighbors before: then
// it takes about half of that cell. The smaller the target, the smaller the raise; each attempt raises by four times
// more.
void revive(const Revival& cells, int attempt, Vector& weights);

}  // namespace votess::fit

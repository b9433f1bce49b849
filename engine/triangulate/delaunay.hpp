// Which seeds may be neighbors, from a Delaunay triangulation of all seeds.
//
// Two seeds whose Voronoi cells share a face of positive area have a sphere through both that is empty and touches no
// third seed; such a pair is an edge of every Delaunay triangulation, however ties are broken, also inside a box. So a
// cell is its box clipped by the bisectors with its seed's neighbors here. This finds the cells that a search cannot
// prove without looking at nearly all seeds: those of seeds near a common sphere.
#pragma once

#include <cstdint>
#include <vector>

#include "index/sort.hpp"
#include "triangulate/triangulation.hpp"

namespace votess::cpu {

class Delaunay {
public:
    explicit Delaunay(const SortedSeeds& seeds);

    // False when the tetrahedra are too many (there may be N^2 / 2).
    [[nodiscard]] bool valid() const { return valid_; }
    // Sorted seeds, ascending. From any thread.
    void neighbors(std::size_t seed, std::vector<std::int32_t>& out) const;

private:
    [[nodiscard]] bool triangulate(Triangulation& triangulation);
    void list_by_vertex();

    std::size_t count_;
    bool valid_ = false;
    // The seeds, then four points of which some are added to seeds that span no tetrahedron.
    std::vector<exact::Point> points_;
    // The finite tetrahedra of each point in a list: from first_[p], neighbor[k] leads on where vertex[k] = p.
    std::vector<Tetrahedron> cells_;
    std::vector<std::int32_t> first_;
};

}  // namespace votess::cpu

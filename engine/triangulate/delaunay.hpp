// Candidates for neighbors, from a Delaunay triangulation of all seeds.
//
// Two seeds whose Voronoi cells share a face of positive area have a sphere through both that is empty and touches no
// third seed. Such a pair is an edge of every Delaunay triangulation, however ties are broken, also inside a box. So a
// cell is its box clipped by the bisectors with its seed's neighbors here. This finds cells that a search could prove
// only from nearly all seeds: those of seeds near a common sphere. The same holds for power diagrams, whose hidden
// seeds have no cell.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "index/sort.hpp"
#include "triangulate/triangulation.hpp"

namespace votess::cpu {

class Delaunay {
public:
    explicit Delaunay(const SortedSeeds& seeds) : Delaunay(seeds.size(), seeds.x, seeds.y, seeds.z) {}
    // Triangulates `count` points, no two of them equal. Fastest where successive ones are near each other.
    Delaunay(std::size_t count, std::span<const double> x, std::span<const double> y, std::span<const double> z);
    // Triangulates `count` sites. Behind them are four more, not coplanar.
    Delaunay(std::size_t count, const Sites& sites);

    // False when there are too many tetrahedra (up to N^2 / 2).
    [[nodiscard]] bool valid() const { return valid_; }
    // Whether a seed has no cell. A lone seed counts as hidden.
    [[nodiscard]] bool is_hidden(std::size_t seed) const { return first_[seed] == Triangulation::unused; }
    // Writes sorted seeds, each once, in any order. From any thread. marks: scratch, all zero between calls.
    void neighbors(std::size_t seed, std::vector<std::int32_t>& out, std::vector<std::uint8_t>& marks) const;

private:
    [[nodiscard]] bool triangulate(Triangulation& triangulation, const Sites& sites) const;
    void list_by_vertex();

    std::size_t count_;
    bool valid_ = false;
    // The finite tetrahedra of each point p, as a list from first_[p]: neighbor[k] is the next, where vertex[k] = p.
    std::vector<Tetrahedron> cells_;
    std::vector<std::int32_t> first_;
};

}  // namespace votess::cpu

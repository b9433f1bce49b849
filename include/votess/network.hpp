// The network of a diagram: its vertices and edges, with the room that they have between the seeds.
//
//     const votess::Network n = votess::network(t, points);  // t has Want::faces
//     n.largest_included().radius;                           // the largest sphere that fits between the seeds
//     n.largest_free()->radius;                              // the largest one that can go on and on
//
// Points far from all seeds lie on vertices, and the ways between them with most room lie along edges. So pores and
// their windows are vertices and edges (Willems, Rycroft, Kazi, Meza, Haranczyk: Algorithms and tools for
// high-throughput geometry-based analysis of crystalline porous materials, Microporous Mesoporous Mater. 149, 2012).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>
#include <votess/votess.hpp>

namespace votess {

// A sphere at a vertex.
struct IncludedSphere {
    double radius;
    std::int32_t vertex;
};
// A sphere that moves along edges to an image of itself, and beyond.
struct FreeSphere {
    double radius;
    std::int32_t edge;        // where it has least room
    IncludedSphere included;  // the largest sphere at the vertices that it reaches
};

// V vertices, E edges. In a periodic domain each is stored once, not for each image.
//
// The radius of a place is its distance to the nearest seed. In a power diagram a seed is a sphere whose radius is the
// square root of its weight, and distances end at its surface. If radii differ, the places with most room are near
// vertices and edges of the power diagram, not on them: results are lower bounds then. Inside of spheres distances are
// negative; where several overlap, it is that of a seed whose cell is there.
struct VOTESS_API Network {
    std::vector<double> points;          // 3V, in the plane 2V, absolute; beyond the box where a cell reaches beyond it
    std::vector<std::int32_t> vertices;  // V, ascending: the first of Tessellation::vertices() that each one stands for
    std::vector<double> vertex_radii;    // V
    std::vector<std::uint8_t> at_walls;  // V: 1 for a vertex on a wall
    std::vector<std::int32_t> edges;     // 2E vertices, the lower one first; in ascending order
    // 3E in a periodic domain, in the plane 2E, else empty: the numbers of box vectors that carry the second vertex to
    // where the edge ends. The first vertex stays.
    std::vector<std::int8_t> shifts;
    std::vector<double> edge_radii;  // E: the smallest radius along each edge

    // Returns the largest sphere at a vertex. Its radius is -infinity, and its vertex -1, if the network is empty.
    [[nodiscard]] IncludedSphere largest_included() const;
    // Returns the largest sphere that can travel without end. axis: only travels along this box vector count, 0, 1 or,
    // in space, 2. Returns nothing without such ways, as in a domain with walls all around. Throws invalid_argument for
    // another axis.
    [[nodiscard]] std::optional<FreeSphere> largest_free(std::optional<int> axis = {}) const;
};

// Returns the network. points: those of the tessellation. Edges to infinity are left out. After min_face or min_area,
// vertices that dropped faces joined count as one, as for delaunay(). Throws invalid_argument without Want::faces, for
// cells of a subset and of probes, for negative weights, and where delaunay() refuses dropped faces.
[[nodiscard]] VOTESS_API Network network(const Tessellation& tessellation, std::span<const double> points);

}  // namespace votess

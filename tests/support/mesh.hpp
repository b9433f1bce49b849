// Judging the mesh of a tessellation: "" when all is well, else one line on the first thing that is wrong.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "support/generators.hpp"

namespace test {

// Box domains, everything wanted. Polygons are closed cells, equal on both sides of a face; vertices lie on their
// planes; the whole is a complex that fills the box: V - E + F - C = 1.
std::string check_mesh(const votess::Tessellation& t, std::span<const double> points);

// For a box: how many cells share each vertex.
std::vector<std::uint32_t> cells_of_vertices(const votess::Tessellation& t);
// Whether a vertex lies inside the box, off its walls.
std::vector<bool> interior_vertices(const votess::Tessellation& t);

// Of tetrahedra with their shifts, all positive; the seeds inside the domain.
double delaunay_volume(const votess::Tessellation& t, const votess::Delaunay& dual, std::span<const double> points);

// The mesh when each cell is clipped by every seed, nearest first, with no search and no star; box domains.
votess::Tessellation mesh_of_clipped_cells(const PointSet& set);
// Equal rows and polygons, vertices within 1e-9 of the box.
std::string check_same_mesh(const votess::Tessellation& a, const votess::Tessellation& b);

}  // namespace test

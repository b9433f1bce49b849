// Checks of the mesh of a tessellation. Each returns one line on the first error, "" when all is right.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "support/generators.hpp"

namespace test {

// For a box and mesh_options(). Polygons close each cell and are equal on both sides of a face. Vertices lie on their
// planes. The complex fills the box: V - E + F - C = 1.
std::string check_mesh(const votess::Tessellation& t, std::span<const double> points);

// Returns how many cells share each vertex of a box.
std::vector<std::uint32_t> cells_of_vertices(const votess::Tessellation& t);
// Returns which vertices lie off the walls of the box.
std::vector<bool> interior_vertices(const votess::Tessellation& t);

// Returns the volume of the tetrahedra with their shifts, -1 when one is not positive.
double delaunay_volume(const votess::Tessellation& t, const votess::Delaunay& dual, std::span<const double> points);

// Returns all_options() with every array wanted.
votess::Options mesh_options(const std::optional<votess::Box>& box = std::nullopt);
votess::Tessellation mesh_of(const PointSet& set);

}  // namespace test

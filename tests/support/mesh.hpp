// Judging the mesh of a tessellation: "" when all is well, else one line on the first thing that is wrong.
#pragma once

#include <cstdint>
#include <string>
#include <votess/votess.hpp>

namespace test {

// Box domains, everything wanted. Polygons are closed cells, equal on both sides of a face; vertices lie on their
// planes; the whole is a complex that fills the box: V - E + F - C = 1.
std::string check_mesh(const votess::Tessellation& t, std::span<const double> points);

// For a box: how many cells share each vertex.
std::vector<std::uint32_t> cells_of_vertices(const votess::Tessellation& t);
// Whether a vertex lies inside the box, off its walls.
std::vector<bool> interior_vertices(const votess::Tessellation& t);

}  // namespace test

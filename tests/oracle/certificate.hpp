// Proves or refutes a tessellation cell by cell, exactly, and much faster than making the cells anew: the faces that a
// row lists bound a polyhedron, whose corners are found in whole numbers; no other seed, image or wall may cut off any
// of them. Any domain.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>
#include <votess/votess.hpp>

namespace test {

// Checks the rows with shifts, statuses and, where t has them, counts, volumes, centroids, areas, normals, surfaces and
// radii of these cells (all cells when empty). One line on the first that is wrong, "" when all are right.
// points and options: as given to tessellate().
std::string check_certificate(const votess::Tessellation& t, std::span<const double> points, votess::Options options,
                              std::vector<std::size_t> cells = {});

}  // namespace test

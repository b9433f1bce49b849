// Closed triangle meshes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
#include <votess/votess.hpp>

#include "support/random.hpp"

namespace test {

struct Solid {
    std::vector<double> vertices;
    std::vector<std::int32_t> triangles;  // counterclockwise seen from outside

    [[nodiscard]] votess::TriangleMesh mesh() const { return {vertices, triangles}; }
    [[nodiscard]] double volume() const;
    [[nodiscard]] double area() const;
    // Returns the same solid inside out: a cavity.
    [[nodiscard]] Solid reversed() const;
};

Solid cuboid(const std::array<double, 3>& lower, const std::array<double, 3>& upper);
Solid cuboid(double lower, double upper);
// Returns a tetrahedron, turned so that its volume is positive. Its corners must not lie in one plane.
Solid tetrahedron(const std::array<std::array<double, 3>, 4>& corners);
// Radii 1 and 0.4, around z; 2 * around * across triangles.
Solid torus(int around, int across);
// A tube of radius 0.2 along a helix of radius 1 and pitch 1 around z, from the x axis on, with flat ends.
Solid spring(int turns, int steps, int across);
// Unit cubes of a grid of nx * ny * nz, without the faces between them. filled: by cube, z fastest.
Solid cubes(const std::array<int, 3>& count, const std::vector<bool>& filled);
// Returns both surfaces.
Solid joined(const Solid& a, const Solid& b);

// Seeds and a solid of which a side lies in a bisector, up to rounding or exactly.
struct NearBisector {
    enum class Kind { lattice, mirrored, rotated, huge, count };  // huge: triangles 1e3 to 1e9 times the cells
    std::vector<double> points;
    Solid solid;
    double reach = 0;  // a box from -reach to reach holds both
};
NearBisector near_bisector(NearBisector::Kind kind, Random& random);

}  // namespace test

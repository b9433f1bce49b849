// Closed triangle meshes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
#include <votess/votess.hpp>

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
// Returns both surfaces.
Solid joined(const Solid& a, const Solid& b);

}  // namespace test

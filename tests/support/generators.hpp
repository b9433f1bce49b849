// Inputs of the tests. Each returns the same points on every platform for the same arguments.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>
#include <votess/votess.hpp>

namespace test {

using Coordinates = std::vector<double>;  // x0 y0 z0 x1 ...

struct PointSet {
    std::string name;
    Coordinates points;
    std::optional<votess::Box> box;  // none: the library's default
    [[nodiscard]] std::size_t size() const { return points.size() / 3; }
};

votess::Box cube(double lower, double upper);
inline votess::Box unit_box() {
    return cube(0, 1);
}

// The eight walls of an octahedron around the middle of the unit box, whose corners are `size` away from it.
std::vector<votess::Wall> octahedron(double size);

// Random points.
PointSet uniform(std::size_t n, std::uint64_t seed);
PointSet clustered(std::size_t n, std::uint64_t seed);        // 50 normal clusters, sigma 0.01 .. 0.05, unit box
PointSet nested_clusters(std::size_t n, std::uint64_t seed);  // clusters inside clusters over 12 decades
PointSet near_duplicates(std::size_t n, std::uint64_t seed);  // groups one step of nextafter apart
PointSet far_from_origin(std::size_t n, std::uint64_t seed);  // 1e8 + 1e-3 r
PointSet on_walls(std::size_t n, std::uint64_t seed);         // on faces, edges and corners of the unit box
PointSet with_duplicates(std::size_t n, std::size_t copies, std::uint64_t seed);  // n points, `copies` of them repeated

// Lattices, integer coordinates unless told otherwise; box half a unit outside.
PointSet cubic(std::size_t per_axis, double spacing = 1);  // point (i, j, k) * spacing; box half a spacing outside
PointSet bcc(int length);
PointSet fcc(int length);
PointSet hexagonal(int length);     // triangular layers of x + y + z = const, straight above each other
PointSet close_packed(int length);  // hexagonal close-packed
PointSet diamond(int length);
PointSet jittered(std::size_t per_axis, double amplitude, std::uint64_t seed);

// Points without volume.
PointSet on_axis_plane(std::size_t n, std::uint64_t seed);
PointSet on_oblique_plane(std::size_t n, std::uint64_t seed);  // integer points of x + 2y + 3z = 0
PointSet on_axis_line(std::size_t n, std::uint64_t seed);
PointSet on_oblique_line(std::size_t n, std::uint64_t seed);       // t * (1, 2, 3)
PointSet on_sphere(std::size_t n, std::uint64_t seed);             // rounded to float64, so only nearly cospherical
PointSet on_sphere_and_center(std::size_t n, std::uint64_t seed);  // the center is the last point

// Exact ties: all integer points of x² + y² + z² = squared_radius, of concentric circles in layers, and of a line.
PointSet cospherical(int squared_radius);
PointSet cospherical_and_center(int squared_radius);  // the center is the last point
PointSet cocircular(int squared_radius, int layers);
// Orders that hand planes to a cell in a bad sequence.
enum class Order { as_made, reversed, interleaved, by_last_coordinate, shuffled };
PointSet reordered(PointSet set, Order order, std::uint64_t seed = 1);

// Coordinates and box times factor.
PointSet scaled(PointSet set, double factor);

// All families above with about n points each (lattices: the nearest size that exists).
std::vector<PointSet> families(std::size_t n, std::uint64_t seed);

}  // namespace test

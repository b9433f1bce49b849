// Vector loops over the planes of a polytope, for the instructions that the processor has. Results do not depend on the
// instructions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vector3.hpp"

namespace votess {

inline constexpr double filter_bound = 0x1p-45, filter_underflow = 0x1p-960;

// Whether products of five such numbers neither underflow nor overflow.
inline bool is_ordinary(double length, double size) {
    constexpr double least = 0x1p-80, most = 0x1p80;
    return (length >= least) & (length <= most) & (size <= most * most);
}

// Squared lengths up to this may have lost digits. Such planes are not ordinary.
inline constexpr double least_square = 1e-290;

// Half-spaces n.x <= d. After the last one come planes that nothing touches, up to a multiple of `lanes`.
struct PlaneArrays {
    static constexpr std::size_t lanes = 4;

    std::vector<double> nx, ny, nz, d, length, size;  // of normals; bounds of |d|
    std::vector<double> inverse, distance;            // of length; size / length
    std::vector<double> power;                        // of bisectors, until complete()
    std::size_t count = 0, padded = 0;
    double longest = 0, largest = 0;  // length, size

    void clear();
    // Appends planes without values. Returns the place of the first one.
    std::size_t append(std::size_t more);
    // Removes the planes from `first` on.
    void remove(std::size_t first);

private:
    void pad();
};

// Where three planes meet.
struct PlaneCorner {
    Vector3 at;              // relative to the seed
    double error;            // of `at`
    double slope, constant;  // n.x - d of a plane is certain beyond slope |n| + constant |d|
    std::array<int, 3> planes;
};

// The edge runs along cross(n of left, n of right), where these are the normals of two faces.
struct PlaneEdge {
    int from, to, left, right;
};

// The polygons around a corner, if they are closed: the one in plane(k), seen from outside, comes from the corner
// after(k - 1), in the sense of (0, 1, 2), and goes to after(k).
struct PlaneFan {
    std::array<std::uint64_t, 4> sides;  // plane, corner before, corner after, in 16 bits each; the last one is unused
    [[nodiscard]] int plane(std::size_t k) const { return static_cast<int>(sides[k] & 0xffff); }
    [[nodiscard]] int after(std::size_t k) const { return static_cast<int>(sides[k] >> 32); }
};

struct Hit {
    int plane = -1;
    double time = 0;
};

struct PlaneLoops {
    // Makes half-spaces of the planes from `first` on, of which normals and powers are there: bisectors of the seed and
    // others.
    void (*complete)(PlaneArrays& planes, std::size_t first);
    // Makes a corner. Returns whether its determinant is certainly positive, and all other planes are certainly beyond.
    bool (*sure_corner)(const PlaneArrays& planes, int a, int b, int c, PlaneCorner& corner);
    // The same, and writes the inverse of d - n.x for all planes, 0 for its own.
    bool (*sure_corner_and_inverses)(const PlaneArrays& planes, int a, int b, int c, PlaneCorner& corner,
                                     double* inverse);
    // Writes the inverse of d - n.x for all planes.
    void (*inverses)(const PlaneArrays& planes, const Vector3& x, double* inverse);
    // Returns the plane that a ray meets first, by rounded numbers; -1 if it meets none.
    Hit (*first_hit)(const PlaneArrays& planes, const double* inverse, const Vector3& along);
    // Adds twice the vector area of each face, seen from the origin, to areas[4 f] to areas[4 f + 2].
    void (*add_areas)(std::span<const PlaneEdge> edges, const PlaneCorner* corners, const Vector3& origin,
                      double* areas);
    // The same of fans, one for each corner.
    void (*add_areas_of_fans)(std::span<const PlaneFan> fans, const PlaneCorner* corners, const Vector3& origin,
                              double* areas);
};
const PlaneLoops& plane_loops();

// Makes a corner. Returns false unless the determinant is certainly positive.
[[gnu::always_inline]] inline bool meet(const PlaneArrays& p, int first, int second, int third, PlaneCorner& corner) {
    const auto a = static_cast<std::size_t>(first), b = static_cast<std::size_t>(second),
               c = static_cast<std::size_t>(third);
    const Vector3 na{p.nx[a], p.ny[a], p.nz[a]}, nb{p.nx[b], p.ny[b], p.nz[b]}, nc{p.nx[c], p.ny[c], p.nz[c]};
    const Vector3 bc = cross(nb, nc), ca = cross(nc, na), ab = cross(na, nb);
    const double w = dot(na, bc), m = p.length[a] * p.length[b] * p.length[c], inverse = 1 / w;
    for (std::size_t k = 0; k < 3; ++k) corner.at[k] = (p.d[a] * bc[k] + p.d[b] * ca[k] + p.d[c] * ab[k]) * inverse;
    corner.constant = filter_bound * m * inverse;
    corner.slope = corner.constant * (p.distance[a] + p.distance[b] + p.distance[c]);
    // The error of W moves the corner along its own direction, which no slack of n.X - d W sees.
    const double reach = std::abs(corner.at[0]) + std::abs(corner.at[1]) + std::abs(corner.at[2]);  // at least
    corner.error = corner.slope + corner.constant * reach;
    corner.planes = {first, second, third};
    return w > filter_bound * m;
}

}  // namespace votess

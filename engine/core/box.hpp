// Points, and boxes along the axes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "core/arithmetic.hpp"
#include "core/vector3.hpp"
#include "votess/votess.hpp"

namespace votess {

// Returns row i of points (N, 3), in units of `scale`.
template <class Numbers>
Vector3 point_of(const Numbers& points, std::size_t i, double scale = 1) {
    return {points[3 * i] * scale, points[3 * i + 1] * scale, points[3 * i + 2] * scale};
}

inline constexpr Box all_space{{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
inline constexpr Box empty_box{all_space.upper, all_space.lower};

inline void include(Box& box, const Box& other) {
    for (std::size_t k = 0; k < 3; ++k) {
        box.lower[k] = std::min(box.lower[k], other.lower[k]);
        box.upper[k] = std::max(box.upper[k], other.upper[k]);
    }
}
inline void include(Box& box, const Vector3& x) {
    include(box, Box{x, x});
}

// Returns the bounds of points (N, 3).
inline Box bounds_of(std::span<const double> points) {
    Box box = empty_box;
    for (std::size_t i = 0; i < points.size() / 3; ++i) include(box, point_of(points, i));
    return box;
}

// Returns the square of the distance between two boxes, rounded.
inline double distance_squared(const Box& a, const Box& b) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double gap = std::max({0.0, a.lower[k] - b.upper[k], b.lower[k] - a.upper[k]});
        sum += gap * gap;
    }
    return sum;
}
inline double distance_squared(const Vector3& x, const Box& box) {
    return distance_squared(Box{x, x}, box);
}

}  // namespace votess

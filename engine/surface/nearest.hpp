// The places of segments and triangles nearest to a place, in double.
#pragma once

#include <algorithm>
#include <limits>

#include "core/vector3.hpp"

namespace votess::surface {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();  // of places that do not exist

[[nodiscard]] inline Vector3 along(const Vector3& from, const Vector3& way, double share) {
    return {from[0] + share * way[0], from[1] + share * way[1], from[2] + share * way[2]};
}

[[nodiscard]] inline double distance(const Vector3& a, const Vector3& b) {
    const Vector3 d = minus(a, b);
    return length3(d[0], d[1], d[2]);
}

[[nodiscard]] inline double square_distance(const Vector3& a, const Vector3& b) {
    const Vector3 d = minus(a, b);
    return dot(d, d);
}

// Returns the place of the segment from a to b nearest to x.
[[nodiscard]] inline Vector3 nearest_on_segment(const Vector3& x, const Vector3& a, const Vector3& b) {
    const Vector3 way = minus(b, a);
    const double square = dot(way, way);
    return square > 0 ? along(a, way, std::clamp(dot(minus(x, a), way) / square, 0.0, 1.0)) : a;
}

// Returns the place of a triangle nearest to x.
[[nodiscard]] inline Vector3 nearest_on_triangle(const Vector3& x, const Vector3& a, const Vector3& b,
                                                 const Vector3& c) {
    const Vector3 n = cross(minus(b, a), minus(c, a));
    const double square = dot(n, n);
    if (square > 0) {
        const Vector3 foot = along(x, n, -dot(minus(x, a), n) / square);
        const auto is_inside = [&](const Vector3& u, const Vector3& v) {
            return dot(cross(minus(v, u), minus(foot, u)), n) >= 0;
        };
        if (is_inside(a, b) && is_inside(b, c) && is_inside(c, a)) return foot;
    }
    Vector3 best = nearest_on_segment(x, a, b);
    double least = square_distance(best, x);
    for (const Vector3& place : {nearest_on_segment(x, b, c), nearest_on_segment(x, c, a)})
        if (const double square = square_distance(place, x); square < least) least = square, best = place;
    return best;
}

}  // namespace votess::surface

// Vectors of three numbers.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace votess {

using Vector3 = std::array<double, 3>;

template <class A, class B>
auto dot(const std::array<A, 3>& a, const std::array<B, 3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class T>
auto cross(const std::array<T, 3>& a, const std::array<T, 3>& b) {
    return std::array{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Vector3 minus(const Vector3& a, const Vector3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// Returns the length, from 0 to infinity. std::hypot() has other last digits in each library.
inline double length3(double x, double y, double z) {
    const double largest = std::max({std::abs(x), std::abs(y), std::abs(z)});
    if (largest == 0) return 0;
    x /= largest, y /= largest, z /= largest;
    return largest * std::sqrt(x * x + y * y + z * z);
}
inline double length3(const Vector3& x) {
    return length3(x[0], x[1], x[2]);
}

}  // namespace votess

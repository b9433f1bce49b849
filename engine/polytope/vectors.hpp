// Vectors of double, Quad or WideFloat, for volumes that are summed in several precisions.
#pragma once

#include <array>
#include <cmath>

#include "core/vector3.hpp"
#include "exact/quad.hpp"
#include "exact/wide_float.hpp"

namespace votess::cpu {

// Unit roundoff; counted as 0 for 2367 bits.
template <class Real>
inline constexpr double roundoff = 0x1p-53;
template <>
inline constexpr double roundoff<exact::Quad> = 0x1p-122;
template <>
inline constexpr double roundoff<exact::WideFloat> = 0;

template <class Real>
using Vector = std::array<Real, 3>;

template <class Real>
Vector<Real> operator-(const Vector<Real>& a, const Vector<Real>& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class Real>
Vector<Real> operator*(const Real& times, const Vector<Real>& a) {
    return {times * a[0], times * a[1], times * a[2]};
}
// Returns the sum of the components' sizes, a bound on the length.
template <class Real>
double length_bound(const Vector<Real>& a) {
    return std::abs(static_cast<double>(a[0])) + std::abs(static_cast<double>(a[1])) +
           std::abs(static_cast<double>(a[2]));
}

}  // namespace votess::cpu

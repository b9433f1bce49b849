// Vectors of three numbers of any type: double, or exact as those of GMP.
#pragma once

#include <gmpxx.h>

#include <array>

namespace test {

template <class Real>
using VectorOf = std::array<Real, 3>;
using RationalVector = VectorOf<mpq_class>;

inline RationalVector rational(const double* x) {
    return {mpq_class(x[0]), mpq_class(x[1]), mpq_class(x[2])};
}

template <class Real>
Real dot(const VectorOf<Real>& a, const VectorOf<Real>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class Real>
VectorOf<Real> cross(const VectorOf<Real>& a, const VectorOf<Real>& b) {
    return {Real(a[1] * b[2] - a[2] * b[1]), Real(a[2] * b[0] - a[0] * b[2]), Real(a[0] * b[1] - a[1] * b[0])};
}
template <class Real>
VectorOf<Real> minus(const VectorOf<Real>& a, const VectorOf<Real>& b) {
    return {Real(a[0] - b[0]), Real(a[1] - b[1]), Real(a[2] - b[2])};
}
template <class Real>
VectorOf<Real> opposite(const VectorOf<Real>& a) {
    return {Real(-a[0]), Real(-a[1]), Real(-a[2])};
}
template <class Real>
Real determinant(const VectorOf<Real>& a, const VectorOf<Real>& b, const VectorOf<Real>& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}
template <class Real>
bool is_zero(const VectorOf<Real>& a) {
    return a[0] == 0 && a[1] == 0 && a[2] == 0;
}

}  // namespace test

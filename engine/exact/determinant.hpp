// Determinants of rows of numbers (double), or of integers whose products are as wide as they need.
#pragma once

namespace votess::exact {

template <class Row>
auto minor_xy(const Row& a, const Row& b) {
    return a[0] * b[1] - b[0] * a[1];
}

template <class N, class M>
auto determinant(const N& az, const N& bz, const N& cz, const M& bc, const M& ac, const M& ab) {
    return (az * bc - bz * ac) + cz * ab;
}

template <class Row>
auto determinant(const Row& a, const Row& b, const Row& c) {
    return determinant(a[2], b[2], c[2], minor_xy(b, c), minor_xy(a, c), minor_xy(a, b));
}

// Expands the rows (x, y, z, lift(row)) by the last column.
template <class Row, class Lift>
auto lifted_determinant(const Row& a, const Row& b, const Row& c, const Row& d, const Lift& lift) {
    const auto ab = minor_xy(a, b), ac = minor_xy(a, c), ad = minor_xy(a, d);
    const auto bc = minor_xy(b, c), bd = minor_xy(b, d), cd = minor_xy(c, d);
    const auto abc = determinant(a[2], b[2], c[2], bc, ac, ab), abd = determinant(a[2], b[2], d[2], bd, ad, ab);
    const auto acd = determinant(a[2], c[2], d[2], cd, ad, ac), bcd = determinant(b[2], c[2], d[2], cd, bd, bc);
    return (abc * lift(d) - abd * lift(c)) + (acd * lift(b) - bcd * lift(a));
}

}  // namespace votess::exact

#include "exact/orthosphere.hpp"

#include <algorithm>
#include <cmath>

#include "exact/integer/rows.hpp"
#include "exact/integer/wide_int.hpp"
#include "exact/quad.hpp"

// Filter: u = 2^-53, m is the largest |N_i|, M the largest |N_i|^2 + |w - w_i|. To first order, errors are at most
//     S                      6u M               C                      4u m^2 a component, 7u m^2 a vector
//     V                     39u M m^2 each, 68u M m^2 a vector      D  11u m^3
//     V.C_i                 98u M m^4           2 D^2 - sum V.C_i   380u M m^4
//     |N_2|^2 S_1 - ...     26u M m^2           2G - sum            110u M m^2
//     S_1 N_2 - S_2 N_1     17u M m each, 30u M m a vector
//     2a - S                19u M
// The factors below are larger by half or more.
namespace votess::exact {
namespace {

constexpr double u = 0x1p-53, tolerance = 0x1p-40;
// Between these nothing underflows that counts, or overflows: degrees are up to 8.
constexpr double min_length = 0x1p-100, max_power = 0x1p60;

int sure_sign(double x, double error) {
    return x > error ? 1 : x < -error ? -1 : 0;
}

// error: of the square's numerator over its denominator. relative: share by which the denominator's root may be wrong.
// It may be all of it for a simplex that is flat up to rounding; then the square is infinite or any number.
bool is_sure(double square, double weight, double error, double relative) {
    return relative <= tolerance && error + square * (2 * relative + 10 * u) <= tolerance * std::abs(square - weight);
}

// The barycentric coordinates of the center, times a positive number, and |c|^2 = numerator / denominator.
template <std::size_t K>
struct Terms {
    double first;
    std::array<double, K> others;
    double numerator, denominator;
};

template <std::size_t K>
Terms<K> terms_of(const std::array<Vector3, K>& n, const std::array<double, K>& s) {
    if constexpr (K == 1) {
        const double a = dot(n[0], n[0]);
        return {2 * a - s[0], {s[0]}, s[0] * s[0], 4 * a};
    } else if constexpr (K == 2) {
        const double a = dot(n[0], n[0]), b = dot(n[0], n[1]), d = dot(n[1], n[1]);
        const auto normal = cross(n[0], n[1]);
        const double g = dot(normal, normal);
        const double first = d * s[0] - b * s[1], second = a * s[1] - b * s[0];
        Vector3 q;
        for (std::size_t k = 0; k < 3; ++k) q[k] = s[0] * n[1][k] - s[1] * n[0][k];
        return {2 * g - (first + second), {first, second}, dot(q, q), 4 * g};
    } else {
        const std::array<Vector3, 3> c{cross(n[1], n[2]), cross(n[2], n[0]), cross(n[0], n[1])};
        const double d = dot(n[0], c[0]);
        Vector3 v;
        for (std::size_t k = 0; k < 3; ++k) v[k] = s[0] * c[0][k] + s[1] * c[1][k] + s[2] * c[2][k];
        const std::array<double, 3> along{dot(v, c[0]), dot(v, c[1]), dot(v, c[2])};
        return {2 * d * d - (along[0] + along[1] + along[2]), along, dot(v, v), 4 * d * d};
    }
}

template <std::size_t K>
std::array<std::int8_t, K + 1> signs_of(const Terms<K>& terms, double first_error, double error) {
    std::array<std::int8_t, K + 1> signs;
    signs[0] = static_cast<std::int8_t>(sure_sign(terms.first, first_error));
    for (std::size_t i = 0; i < K; ++i) signs[i + 1] = static_cast<std::int8_t>(sure_sign(terms.others[i], error));
    return signs;
}

}  // namespace

template <std::size_t K>
std::optional<Orthosphere<K>> sure_orthosphere(const std::array<Vector3, K>& n, const std::array<double, K>& powers,
                                               double weight) {
    std::array<double, K> s;
    double mm = 0, largest = 0;  // m^2, M
    for (std::size_t i = 0; i < K; ++i) {
        const double square = dot(n[i], n[i]);
        s[i] = square + powers[i];
        mm = std::max(mm, square);
        largest = std::max(largest, square + std::abs(powers[i]));
    }
    const double m = std::sqrt(mm);
    if (!(m > min_length && largest < max_power)) return {};
    const Terms<K> terms = terms_of(n, s);
    const double unit = u * largest;
    double wrong, relative;  // errors of the root of the numerator, and of that of the denominator as a share
    std::array<std::int8_t, K + 1> signs;
    if constexpr (K == 1) {
        signs = signs_of(terms, 32 * unit, 10 * unit);
        wrong = 10 * unit;
        relative = 5 * u;
    } else if constexpr (K == 2) {
        signs = signs_of(terms, 200 * unit * mm, 40 * unit * mm);
        wrong = 50 * unit * m;
        relative = 24 * u * mm / std::sqrt(terms.denominator);
    } else {
        signs = signs_of(terms, 600 * unit * mm * mm, 150 * unit * mm * mm);
        wrong = 110 * unit * mm;
        relative = 36 * u * mm * m / std::sqrt(terms.denominator);
    }
    if (std::ranges::find(signs, 0) != signs.end()) return {};
    const double center = terms.numerator / terms.denominator;
    const double error = (2 * std::sqrt(terms.numerator) + wrong) * wrong / terms.denominator;
    if (!is_sure(center, weight, error, relative)) return {};
    return Orthosphere<K>{center - weight, signs};
}

namespace {

template <int W>
WideInt<W> twice(const WideInt<W>& x) {
    return x + x;
}

template <class T>
std::int8_t sign_byte(const T& x) {
    return static_cast<std::int8_t>(x.sign());
}

// |c|^2 = numerator / (4 denominator)
template <int W, int Numerator, int Denominator>
double square_of(const WideInt<Numerator>& numerator, const WideInt<Denominator>& denominator, double weight,
                 int quantum) {
    const auto below = twice(twice(resize<Denominator + 1>(denominator)));
    const auto power = below * to_wide<2 * W>(weight, 2 * quantum);
    constexpr int width = std::max(Numerator, Denominator + 1 + 2 * W) + 1;
    const auto above = resize<width>(numerator) - resize<width>(power);
    if (above.zero()) return 0;
    return static_cast<double>(ldexp(Quad(above) / Quad(below), 2 * quantum));
}

// Coordinates of seeds fit W limbs.
template <int W, std::size_t K>
Orthosphere<K> orthosphere_in(const Point& seed, double weight, const std::array<Plane, K>& bisectors, int quantum) {
    std::array<WideRow<W>, K> rows;
    for (std::size_t i = 0; i < K; ++i) rows[i] = wide_row<W>(seed, bisectors[i], quantum);
    const auto& n = rows[0].n;
    const auto& s = rows[0].s;
    Orthosphere<K> sphere;
    if constexpr (K == 1) {
        const auto a = dot(n, n);
        sphere.signs = {sign_byte(twice(a) - s), sign_byte(s)};
        sphere.square = square_of<W>(s * s, a, weight, quantum);
    } else if constexpr (K == 2) {
        const auto& n2 = rows[1].n;
        const auto& s2 = rows[1].s;
        const auto normal = cross(n, n2);
        const auto b = dot(n, n2);
        const auto g = dot(normal, normal);
        const auto first = dot(n2, n2) * s - b * s2, second = dot(n, n) * s2 - b * s;
        sphere.signs = {sign_byte(twice(g) - (first + second)), sign_byte(first), sign_byte(second)};
        std::array<WideInt<3 * W>, 3> q;
        for (std::size_t k = 0; k < 3; ++k) q[k] = s * n2[k] - s2 * n[k];
        sphere.square = square_of<W>(dot(q, q), g, weight, quantum);
    } else {
        const std::array<std::array<WideInt<2 * W>, 3>, 3> c{cross(rows[1].n, rows[2].n), cross(rows[2].n, n),
                                                             cross(n, rows[1].n)};
        const auto d = dot(n, c[0]);
        std::array<WideInt<4 * W>, 3> v;
        for (std::size_t k = 0; k < 3; ++k) v[k] = s * c[0][k] + rows[1].s * c[1][k] + rows[2].s * c[2][k];
        const auto dd = d * d;
        const std::array along{dot(v, c[0]), dot(v, c[1]), dot(v, c[2])};
        sphere.signs = {sign_byte(twice(dd) - (along[0] + along[1] + along[2])), sign_byte(along[0]),
                        sign_byte(along[1]), sign_byte(along[2])};
        sphere.square = square_of<W>(dot(v, v), dd, weight, quantum);
    }
    return sphere;
}

}  // namespace

template <std::size_t K>
Orthosphere<K> orthosphere(const Point& seed, double weight, const std::array<Plane, K>& bisectors) {
    Plane own;  // for the range of the weight
    own.power.high = weight;
    BitRange range;
    range.add(seed);
    range.add(own);
    for (const Plane& bisector : bisectors) range.add(bisector);
    const int quantum = range.quantum();
    // Every product has room for its factors. Sums need less than four bits.
    if (range.span() <= 59) return orthosphere_in<1, K>(seed, weight, bisectors, quantum);
    if (range.span() <= 123) return orthosphere_in<2, K>(seed, weight, bisectors, quantum);
    if (range.span() <= middle_bits) return orthosphere_in<middle, K>(seed, weight, bisectors, quantum);
    return orthosphere_in<widest, K>(seed, weight, bisectors, quantum);
}

template std::optional<Orthosphere<1>> sure_orthosphere(const std::array<Vector3, 1>&, const std::array<double, 1>&,
                                                        double);
template std::optional<Orthosphere<2>> sure_orthosphere(const std::array<Vector3, 2>&, const std::array<double, 2>&,
                                                        double);
template std::optional<Orthosphere<3>> sure_orthosphere(const std::array<Vector3, 3>&, const std::array<double, 3>&,
                                                        double);
template Orthosphere<1> orthosphere(const Point&, double, const std::array<Plane, 1>&);
template Orthosphere<2> orthosphere(const Point&, double, const std::array<Plane, 2>&);
template Orthosphere<3> orthosphere(const Point&, double, const std::array<Plane, 3>&);

}  // namespace votess::exact

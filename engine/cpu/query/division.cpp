#include "cpu/query/division.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace votess::cpu {
namespace {

using Vector = Division::Vector;

constexpr double most_unbalanced = 1e-12;  // of the sum of volumes times distances

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector minus(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

void add(Vector& to, const Vector& x, double times) {
    for (std::size_t k = 0; k < 3; ++k) to[k] += times * x[k];
}

}  // namespace

std::size_t Division::add_neighbor(std::int32_t seed, const Vector& n, double h) {
    if (count_ == most_neighbors) return most_neighbors;
    seeds_[count_] = seed;
    nx_[count_] = n[0], ny_[count_] = n[1], nz_[count_] = n[2];
    h_[count_] = h;
    areas_[count_] = moment_[count_] = {};
    known_[count_] = 0;
    return count_++;
}

Division::Planes Division::planes() {
    for (std::size_t i = count_; i % 4 != 0; ++i) nx_[i] = ny_[i] = nz_[i] = 0, h_[i] = never;
    return {nx_.data(), ny_.data(), nz_.data(), h_.data(), (count_ + 3) / 4 * 4};
}

Vector Division::direction(std::size_t a, std::size_t b, std::size_t c) const {
    return cross(minus(normal(b), normal(a)), minus(normal(c), normal(a)));
}

void Division::add_across(std::size_t a, std::size_t b, const Vector& across, double sign) {
    if (a > b) std::swap(a, b), sign = -sign;
    Vector& sum = across_[most_neighbors * a + b];
    if ((known_[a] >> b & 1) == 0) sum = {};
    known_[a] |= 1u << b;
    add(sum, across, sign);
}

void Division::add_rim(std::size_t a, std::size_t b, const Vector& v, const Vector& w) {
    const Vector across = cross(v, w);
    add(areas_[a], across, 0.5);
    add(areas_[b], across, -0.5);
    add_across(a, b, across, -1);
    if (!moments_) return;
    for (const std::size_t f : {a, b}) {
        const Vector n = normal(f);
        const double square = dot(n, n), foot = h_[f] / square;
        const Vector at{foot * n[0], foot * n[1], foot * n[2]};
        const double size = 0.5 * dot(cross(minus(v, at), minus(w, at)), n) / std::sqrt(square) * (f == a ? 1 : -1);
        for (std::size_t k = 0; k < 3; ++k) moment_[f][k] += size * (at[k] + v[k] + w[k]) / 3;
    }
}

void Division::add_inner(std::size_t a, std::size_t b, std::size_t c, const Vector& v, const Vector& w) {
    const Vector across = cross(v, w);
    add_across(a, b, across, 1);
    add_across(b, c, across, 1);
    add_across(c, a, across, 1);
}

bool Division::finish() {
    for (std::size_t a = 0; a < count_; ++a) {
        const Vector n = normal(a);
        volumes_[a] = h_[a] / dot(n, n) * dot(n, areas_[a]) / 3;
    }
    for (std::size_t a = 0; a < count_; ++a)
        for (std::uint32_t rest = known_[a]; rest != 0; rest &= rest - 1) {
            const auto b = static_cast<std::size_t>(std::countr_zero(rest));
            const Vector n = minus(normal(b), normal(a));
            const double part = (h_[b] - h_[a]) / dot(n, n) * dot(n, across_[most_neighbors * a + b]) / 6;
            volumes_[a] += part;
            volumes_[b] -= part;
        }
    Vector sum{};
    double size = 0, least = 0;
    for (std::size_t a = 0; a < count_; ++a) {
        const Vector n = normal(a);
        add(sum, n, volumes_[a]);
        size += std::abs(volumes_[a]) * std::sqrt(dot(n, n));
        least = std::min(least, volumes_[a]);
    }
    return least == 0 && dot(sum, sum) <= most_unbalanced * most_unbalanced * size * size;
}

}  // namespace votess::cpu

#include "cpu/query/division.hpp"

#include <algorithm>
#include <cmath>

#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

using Vector = Division::Vector;

constexpr double most_unbalanced = 1e-12;  // of the sum of volumes times distances

}  // namespace

std::size_t Division::add_neighbor(std::int32_t seed, const Vector& n, double h) {
    if (count_ == most_neighbors) return most_neighbors;
    seeds_[count_] = seed;
    nx_[count_] = n[0], ny_[count_] = n[1], nz_[count_] = n[2];
    h_[count_] = h;
    areas_[count_] = moment_[count_] = {};
    return count_++;
}

Division::Planes Division::planes() {
    for (std::size_t i = count_; i % 4 != 0; ++i) nx_[i] = ny_[i] = nz_[i] = 0, h_[i] = never;
    return {nx_.data(), ny_.data(), nz_.data(), h_.data(), (count_ + 3) / 4 * 4};
}

Vector Division::direction(std::size_t a, std::size_t b, std::size_t c) const {
    return cross(minus(normal(b), normal(a)), minus(normal(c), normal(a)));
}

void Division::add_moments(std::size_t a, std::size_t b, const Vector& v, const Vector& w) {
    for (const std::size_t f : {a, b}) {
        const Vector n = normal(f);
        const double square = dot(n, n), foot = h_[f] / square;
        const Vector at{foot * n[0], foot * n[1], foot * n[2]};
        const double size = 0.5 * dot(cross(minus(v, at), minus(w, at)), n) / std::sqrt(square) * (f == a ? 1 : -1);
        for (std::size_t k = 0; k < 3; ++k) moment_[f][k] += size * (at[k] + v[k] + w[k]) / 3;
    }
}

bool Division::finish() {
    for (std::size_t a = 0; a < count_; ++a) {
        const Vector n = normal(a);
        volumes_[a] = h_[a] / dot(n, n) * dot(n, areas_[a]) / 6;
    }
    for (std::size_t k = 0; k < known_count_; ++k) {
        const Pair& pair = pairs_[known_[k]];
        const double x = nx_[pair.b] - nx_[pair.a], y = ny_[pair.b] - ny_[pair.a], z = nz_[pair.b] - nz_[pair.a];
        const double times = x * pair.across[0] + y * pair.across[1] + z * pair.across[2];
        const double part = (h_[pair.b] - h_[pair.a]) * times / (6 * (x * x + y * y + z * z));
        volumes_[pair.a] += part;
        volumes_[pair.b] -= part;
    }
    Vector sum{};
    double size = 0, least = 0;
    for (std::size_t a = 0; a < count_; ++a) {
        const Vector n = normal(a);
        for (std::size_t k = 0; k < 3; ++k) sum[k] += n[k] * volumes_[a];
        size += std::abs(volumes_[a]) * std::sqrt(dot(n, n));
        least = std::min(least, volumes_[a]);
    }
    return least == 0 && dot(sum, sum) <= most_unbalanced * most_unbalanced * size * size;
}

}  // namespace votess::cpu

#include "query/division.hpp"

#include <algorithm>
#include <cmath>

#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

using Vector = Division::Vector;

// The terms of a share are products of a neighbor's distance and two corners. `rounding` bounds the sum of their
// errors, relative to the largest product. `accepted_error` is relative to the volume of P.
constexpr double rounding = 0x1p-50, accepted_error = 0x1p-40;
// Bisectors of neighbors whose distance is a smaller share of that of the farthest neighbor have lost digits.
constexpr double min_apart = 0x1p-8;
// Gradients of shares are divided by the distance of the nearest neighbor.
constexpr double min_near = 0x1p-20;

}  // namespace

std::size_t Division::add_neighbor(std::int32_t seed, const Vector& n, double h) {
    const std::size_t a = add_wall(n, h);
    if (a == max_neighbors) return a;
    seeds_[a] = seed;
    moment_[a] = {};
    volumes_[a] = 0;
    return neighbors_++;
}

std::size_t Division::add_wall(const Vector& n, double h) {
    if (count_ == max_neighbors) return max_neighbors;
    nx_[count_] = n[0], ny_[count_] = n[1], nz_[count_] = n[2];
    h_[count_] = h;
    return count_++;
}

Vector Division::direction(std::size_t a, std::size_t b, std::size_t c) const {
    const auto away = [&](std::size_t i) { return is_wall(i) ? normal(i) : minus(normal(i), normal(a)); };
    return cross(away(b), away(c));
}

bool Division::add_corner(std::size_t a, std::size_t b, std::size_t c, const Vector& x) {
    if (corner_count_ == max_corners) return false;
    farthest_squared_ = std::max(farthest_squared_, dot(x, x));
    std::uint16_t* const edges = &edges_[3 * corner_count_];
    corners_[corner_count_++] = x;
    edges[0] = static_cast<std::uint16_t>(max_neighbors * a + b);
    edges[1] = static_cast<std::uint16_t>(max_neighbors * b + c);
    edges[2] = static_cast<std::uint16_t>(max_neighbors * c + a);
    for (std::size_t e = 0; e < 3; ++e) ends_[edges[e]] = static_cast<std::uint16_t>(corner_count_);
    return true;
}

bool Division::add_rims() {
    std::size_t forward = 0, backward = 0;  // each edge ends at one corner around a, at the other around b
    for (std::size_t e = 0; e < 3 * corner_count_; ++e) {
        const std::size_t a = edges_[e] / max_neighbors, b = edges_[e] % max_neighbors;
        if (is_wall(std::min(a, b))) continue;
        if (a > b) {
            ++backward;
            continue;
        }
        const std::uint16_t end = ends_[edges_[e]], begin = ends_[max_neighbors * b + a];
        if (begin == 0) return false;
        add_rim(a, b, corners_[begin - 1u], corners_[end - 1u]);
        ++forward;
    }
    return forward == backward;
}

void Division::add_moments(std::size_t a, std::size_t b, const Vector& v, const Vector& w) {
    for (const std::size_t f : {a, b}) {
        if (is_wall(f)) continue;
        const Vector n = normal(f);
        const double square = dot(n, n), foot = h_[f] / square;
        const Vector at{foot * n[0], foot * n[1], foot * n[2]};
        const double size = 0.5 * dot(cross(minus(v, at), minus(w, at)), n) / std::sqrt(square) * (f == a ? 1 : -1);
        for (std::size_t k = 0; k < 3; ++k) moment_[f][k] += size * (at[k] + v[k] + w[k]) / 3;
    }
}

// Returns (2 R - a).across, with R on the plane between the parts of a and b, or on the wall b. All edges of a face use
// the same R.
double Division::beyond(std::size_t a, std::size_t b, const Vector& across) {
    if (b == probe) {
        if (!weighted_) return 0;
        const Vector n = normal(a);
        return (2 * h_[a] / dot(n, n) - 1) * along(a, across);
    }
    if (is_wall(b)) {
        const Vector n = normal(b);
        return 2 * h_[b] / dot(n, n) * along(b, across) - along(a, across);
    }
    if (!weighted_) return along(b, across);
    const Vector d = minus(normal(b), normal(a));
    const double apart_squared = dot(d, d);
    min_apart_squared_ = std::min(min_apart_squared_, apart_squared);
    return 2 * (h_[b] - h_[a]) / apart_squared * dot(d, across) - along(a, across);
}

void Division::add_general(std::size_t a, std::size_t b, std::size_t c, const Vector& across) {
    for (const auto& [own, next, last] : {std::array{a, b, c}, {b, c, a}, {c, a, b}})
        if (!is_wall(own)) volumes_[own] += beyond(own, next, across) - beyond(own, last, across);
}

bool Division::finish() {
    double total = 0, least = std::numeric_limits<double>::infinity(), longest_squared = 0, highest = 0;
    double shortest_squared = least;
    for (std::size_t a = 0; a < neighbors_; ++a) {
        volumes_[a] /= 12;
        total += volumes_[a];
        least = std::min(least, volumes_[a]);
        const double square = nx_[a] * nx_[a] + ny_[a] * ny_[a] + nz_[a] * nz_[a];
        longest_squared = std::max(longest_squared, square);
        shortest_squared = std::min(shortest_squared, square);
        highest = std::max(highest, std::abs(h_[a]));
    }
    if (moments_ && !(shortest_squared >= min_near * min_near * longest_squared)) return false;
    const double longest = std::sqrt(longest_squared), farthest = std::sqrt(farthest_squared_);
    const double error = rounding * (longest + 2 * farthest) * farthest_squared_;
    return total > 0 && error <= accepted_error * total && least > error && highest <= 4 * longest * farthest &&
           min_apart_squared_ >= min_apart * min_apart * longest_squared;
}

}  // namespace votess::cpu

#include "domain/wall_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace votess {
namespace {

constexpr double unit_roundoff = 0x1p-53;

// Returns how many nodes of a complete tree of `count` lie below its first child.
std::size_t count_of_first(std::size_t count) {
    const std::size_t last_level = std::bit_floor(count);
    const std::size_t in_last = count + 1 - last_level;
    return (last_level >> 1) - 1 + std::min(in_last, last_level >> 1);
}

}  // namespace

WallTree::WallTree(std::span<const exact::Plane> walls, const exact::Point& middle)
    : middle_(middle), nodes_(walls.size()) {
    std::vector<Unit> units;
    units.reserve(walls.size());
    for (const exact::Plane& wall : walls) {
        const auto& n = wall.seed;
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        double offset = wall.wall, size = std::abs(wall.wall);
        for (std::size_t k = 0; k < 3; ++k) {
            offset -= n[k] * middle[k];
            size += std::abs(n[k] * middle[k]);
        }
        units.push_back(
            {{n[0] / length, n[1] / length, n[2] / length}, offset / length, static_cast<std::uint32_t>(units.size())});
        error_ = std::max(error_, 16 * unit_roundoff * size / length);
    }
    build(units, 0);
}

void WallTree::build(std::span<Unit> walls, std::size_t node) {
    if (walls.empty()) return;
    Node made{walls[0].n, walls[0].n, walls[0].offset, 0};
    for (const Unit& wall : walls) {
        for (std::size_t k = 0; k < 3; ++k) {
            made.lower[k] = std::min(made.lower[k], wall.n[k]);
            made.upper[k] = std::max(made.upper[k], wall.n[k]);
        }
        made.offset = std::min(made.offset, wall.offset);
    }
    std::size_t widest = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (made.upper[k] - made.lower[k] > made.upper[widest] - made.lower[widest]) widest = k;
    const std::size_t first = walls.size() == 1 ? 0 : count_of_first(walls.size());
    std::nth_element(walls.begin(), walls.begin() + static_cast<std::ptrdiff_t>(first), walls.end(),
                     [widest](const Unit& a, const Unit& b) { return a.n[widest] < b.n[widest]; });
    made.wall = walls[first].wall;
    nodes_[node] = made;
    build(walls.first(first), 2 * node + 1);
    build(walls.subspan(first + 1), 2 * node + 2);
}

// The normals n of a node lie in a box, which reaches beyond the unit sphere by as much as it is wide. Near a round
// hull of n walls it alone would leave sqrt(n) nodes to visit, instead of log(n). So they also lie in a cone: with the
// middle m and the half diagonal r of the box, n.m = (1 + |m|^2 - |n - m|^2) / 2 >= (1 + |m|^2 - r^2) / 2. Over a cone,
// n.x is largest on the side of x: |x| cos(angle of x - half angle), or |x| if x lies inside.
bool WallTree::may_exclude(std::size_t node, const exact::Point& x, double tolerance) const {
    constexpr double least_square = 0x1p-900;  // smaller ones have lost digits
    const Node& n = nodes_[node];
    double most = 0, square = 0, along = 0, size = std::abs(n.offset), middle = 0, radius = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double from = x[k] - middle_[k], m = 0.5 * (n.lower[k] + n.upper[k]), r = 0.5 * (n.upper[k] - n.lower[k]);
        most += std::max(n.lower[k] * from, n.upper[k] * from);
        square += from * from;
        along += m * from;
        middle += m * m;
        radius += r * r;
        size += std::abs(x[k]) + std::abs(middle_[k]);
    }
    const double nearest = n.offset - (2 * tolerance + error_ + 32 * unit_roundoff * size);
    if (most < nearest) return false;
    if (!(square > least_square && nearest > 0)) return true;  // also if a number is not finite
    if (square < nearest * nearest) return false;
    const double cosine = 0.5 * (1 + middle - radius) - 32 * unit_roundoff;  // of the half angle, times |m|
    if (!(cosine > 0.5) || (along > 0 && along * along >= cosine * cosine * square)) return true;
    const double sine = std::sqrt(std::max(0.0, middle - cosine * cosine) + 32 * unit_roundoff);
    const double beside = std::sqrt(std::max(0.0, middle * square - along * along) + 32 * unit_roundoff * square);
    return !(cosine * along + sine * beside < nearest * middle);
}

}  // namespace votess

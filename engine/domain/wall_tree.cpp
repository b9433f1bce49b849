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

bool WallTree::may_exclude(std::size_t node, const exact::Point& x, double tolerance) const {
    const Node& n = nodes_[node];
    double most = 0, square = 0, size = std::abs(n.offset);
    for (std::size_t k = 0; k < 3; ++k) {
        const double from = x[k] - middle_[k];
        most += std::max(n.lower[k] * from, n.upper[k] * from);
        square += from * from;
        size += std::abs(x[k]) + std::abs(middle_[k]);
    }
    const double nearest = n.offset - (2 * tolerance + error_ + 16 * unit_roundoff * size);
    return !(most < nearest || (nearest > 0 && square < nearest * nearest));  // also if a number is not finite
}

}  // namespace votess

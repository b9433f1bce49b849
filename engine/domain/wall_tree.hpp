// A tree over many walls, to find those that may cut a cell or exclude a seed.
//
// Each node holds one wall. The walls of the nodes below are split at it, by the coordinate of the unit normal that
// varies most. Nodes are numbered level by level: below node i are 2 i + 1 and 2 i + 2. So any number of first nodes
// has walls of all directions, and successive nodes have similar ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "exact/predicate.hpp"

namespace votess {

class WallTree {
public:
    WallTree() = default;
    // All walls are oblique. middle: of the domain; any place gives right answers, a near one excludes more.
    WallTree(std::span<const exact::Plane> walls, const exact::Point& middle);

    [[nodiscard]] std::size_t size() const { return nodes_.size(); }
    // Returns the index of a node's wall.
    [[nodiscard]] std::size_t wall(std::size_t node) const { return nodes_[node].wall; }
    // Returns false only if x is certainly inside all walls of the node and of those below. tolerance: bound on the
    // distance to the exact place.
    [[nodiscard]] bool may_exclude(std::size_t node, const exact::Point& x, double tolerance) const;

private:
    struct Node {
        std::array<double, 3> lower, upper;  // of unit normals, of the node and of those below
        double offset;                       // least distance of a wall from the middle
        std::uint32_t wall;
    };
    struct Unit {  // a wall with a normal of length 1
        std::array<double, 3> n;
        double offset;  // from the middle
        std::uint32_t wall;
    };
    void build(std::span<Unit> walls, std::size_t node);

    exact::Point middle_{};
    double error_ = 0;  // of offsets and of n.x
    std::vector<Node> nodes_;
};

}  // namespace votess

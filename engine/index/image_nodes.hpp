// Images that are not among the sorted ones: a node of the hierarchy with a range of shifts. A search splits it until
// one image of one seed remains.
#pragma once

#include <algorithm>
#include <cstdint>

#include "domain/domain.hpp"
#include "index/hierarchy.hpp"
#include "index/sorted_seeds.hpp"

namespace votess::cpu {

struct ImageNode {
    std::int32_t level;  // -1: a single seed
    std::uint32_t node;
    ShiftRange shifts;

    [[nodiscard]] bool is_single() const { return level < 0 && shifts.is_single(); }
};

// Without images.
inline Box box_of(const ImageNode& node, const SortedSeeds& seeds, const Hierarchy& hierarchy) {
    if (node.level >= 0) return hierarchy.box(node.level, node.node);
    const std::array<double, 3> x{seeds.x[node.node], seeds.y[node.node], seeds.z[node.node]};
    return {x, x};
}

// Calls visit for the parts of a node that is not single. Halves the range of shifts or opens the box, whichever
// extends farther, so that a thin or long domain costs little more than a cube.
template <class Visit>
void for_each_part(const ImageNode& node, const Domain& domain, const SortedSeeds& seeds, const Hierarchy& hierarchy,
                   Visit visit) {
    const Box box = box_of(node, seeds, hierarchy);
    double side = 0;
    for (int k = 0; k < 3; ++k) side = std::max(side, box.upper[k] - box.lower[k]);
    const Extent extent = longest_extent(domain, node.shifts);
    if (node.level < 0 || extent.length > side) {
        for (const ShiftRange& half : halves(node.shifts, extent.axis)) visit(ImageNode{node.level, node.node, half});
        return;
    }
    const std::size_t begin = std::size_t{node.node} * Hierarchy::fan;
    const std::size_t end =
        node.level > 0 ? std::min(begin + Hierarchy::fan, hierarchy.count(node.level - 1)) : seeds.group_end(begin);
    for (std::size_t child = begin; child < end; ++child)
        if (node.level == 0 || Hierarchy::first_seed(node.level - 1, child) < seeds.size())  // the others hold images
            visit(ImageNode{node.level - 1, static_cast<std::uint32_t>(child), node.shifts});
}

}  // namespace votess::cpu

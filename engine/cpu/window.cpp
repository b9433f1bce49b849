#include "cpu/window.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace votess::cpu {
namespace {

constexpr std::size_t most_groups = 160;  // more make it cheaper to look twice
constexpr std::size_t least_groups = 4;   // fewer tell nothing about the surroundings
constexpr int most_tries = 12;
constexpr double smallest_extent = 1e-280;  // units would overflow

}  // namespace

bool Window::collect(std::size_t group, const BoundingBox& home, double distance_squared, std::size_t most,
                     const Neighborhood& cells) {
    groups_.clear();
    stack_.assign(1, {hierarchy_.top_level(), 0});
    while (!stack_.empty()) {
        const Node node = stack_.back();
        stack_.pop_back();
        unsigned near = kernels_.near_boxes(hierarchy_.block(node.level, node.index), home, distance_squared);
        for (; near != 0; near &= near - 1) {
            const std::uint32_t child = node.index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near));
            if (node.level > 0)
                stack_.push_back({node.level - 1, child});
            else if (child == group || !cells.group_done(child))
                groups_.push_back(child);
        }
        if (groups_.size() > most) return false;
    }
    return true;
}

bool Window::open(std::size_t group, double radius, const Neighborhood& cells) {
    const BoundingBox home = hierarchy_.box(0, group);
    for (int tries = 0;; ++tries) {
        const bool all = collect(group, home, radius * radius * (1 + 1e-12), most_groups, cells);
        if (tries == most_tries) {
            if (!all) return false;
            break;
        }
        if (!all)
            radius *= 0.7;
        else if (groups_.size() < least_groups && groups_.size() < hierarchy_.count(0))
            radius *= 1.5;
        else
            break;
    }
    double extent = 0, origin[3];
    for (int k = 0; k < 3; ++k) {
        origin[k] = 0.5 * home.lower[k] + 0.5 * home.upper[k];
        extent = std::max(extent, home.upper[k] - home.lower[k]);
    }
    extent = 0.5 * extent + radius;
    if (!(extent > smallest_extent && extent < 1 / smallest_extent)) return false;
    // Twice the extent, times the scale, is at most window_range * (1 - 2^-20): the rounding of origin and extent.
    scale_ = std::ldexp(1.0, 28 - std::ilogb(extent) - 1);
    reach_ = radius;

    const std::size_t count = groups_.size() * group_size;
    for (auto* v : {&x_, &y_, &z_, &id_})
        if (v->size() < count + 16) v->resize(count + 16);
    std::size_t at = 0;
    for (const std::uint32_t g : groups_) {
        const std::size_t begin = std::size_t{g} * group_size;
        if (g == group) home_ = at;
        kernels_.to_window(&seeds_.x[begin], origin[0], scale_, &x_[at]);
        kernels_.to_window(&seeds_.y[begin], origin[1], scale_, &y_[at]);
        kernels_.to_window(&seeds_.z[begin], origin[2], scale_, &z_[at]);
        for (std::size_t k = 0; k < group_size; ++k) id_[at + k] = static_cast<std::int32_t>(begin + k);
        at += group_size;
    }
    for (std::size_t k = at; k < at + 16; ++k) x_[k] = y_[k] = z_[k] = far_away, id_[k] = 0;
    count_ = static_cast<int>(at);
    return true;
}

}  // namespace votess::cpu

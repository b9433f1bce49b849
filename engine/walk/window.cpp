#include "walk/window.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "index/seed_images.hpp"
#include "walk/star_bounds.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t min_groups = 4;  // fewer say nothing about the surroundings
constexpr int max_tries = 12;
constexpr double widest_span = 1e28;        // of weights in squared units, which are floats
constexpr double smallest_extent = 1e-280;  // units would overflow

}  // namespace

bool Window::collect(const Box& box, double distance_squared) {
    group_count_ = 0;
    std::size_t nodes = 1;
    stack_[0] = {hierarchy_.top_level(), 0};
    while (nodes > 0) {
        const Node node = stack_[--nodes];
        const unsigned near = kernels_.near_boxes(hierarchy_.block(node.level, node.index), box, distance_squared);
        const std::uint32_t first = node.index * box_fan;
        // Without branches, which would be mispredicted.
        if (node.level > 0) {
            for (std::uint32_t k = 0; k < box_fan; ++k) {
                stack_[nodes] = {node.level - 1, first + k};
                nodes += (near >> k) & 1;
            }
        } else {
            for (std::uint32_t k = 0; k < box_fan; ++k) {
                groups_[group_count_] = first + k;
                group_count_ += (near >> k) & 1;
            }
            if (group_count_ > max_groups) return false;
        }
    }
    return true;
}

Box Window::home_box(std::size_t home) const {
    const std::size_t first_group = home * home_groups;
    Box box = hierarchy_.box(0, first_group);
    for (std::size_t g = first_group + 1; g < std::min(first_group + home_groups, hierarchy_.count(0)); ++g) {
        const Box other = hierarchy_.box(0, g);
        for (int k = 0; k < 3; ++k) {
            box.lower[k] = std::min(box.lower[k], other.lower[k]);
            box.upper[k] = std::max(box.upper[k], other.upper[k]);
        }
    }
    return box;
}

bool Window::open(std::size_t home, const Box& box, double radius, double weight, const Neighborhood& cells) {
    for (int tries = 0;; ++tries) {
        const bool all = collect(box, radius * radius * (1 + 1e-12));
        if (tries == max_tries) {
            if (!all) return false;
            break;
        }
        if (!all)
            radius *= 0.7;
        else if (group_count_ < min_groups && group_count_ < hierarchy_.count(0))
            radius *= 1.5;
        else
            break;
    }
    // Seeds of the home come first and whole. Groups that are done are skipped.
    std::size_t kept = 0, left = 0;
    for (std::size_t i = 0; i < group_count_; ++i) {
        const std::uint32_t g = groups_[i];
        if (g / home_groups == home) {
            groups_[left++] = groups_[kept];
            groups_[kept++] = g;
        } else {
            groups_[left] = g;
            left += cells.group_done(g) ? 0 : 1;
        }
    }
    group_count_ = left;
    home_places_.fill(std::numeric_limits<std::size_t>::max() / 2);
    for (std::size_t i = 0; i < kept; ++i) home_places_[groups_[i] % home_groups] = i * group_size;
    double extent = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        origin_[k] = 0.5 * box.lower[k] + 0.5 * box.upper[k];
        extent = std::max(extent, box.upper[k] - box.lower[k]);
    }
    extent = 0.5 * extent + radius;
    if (!(extent > smallest_extent && extent < 1 / smallest_extent)) return false;
    // Twice the extent, times the scale, is at most window_range * (1 - 2^-20), which covers the rounding of origin and
    // extent.
    scale_ = std::ldexp(1.0, 28 - std::ilogb(extent) - 1);
    // Images are rounded, seeds are not.
    if (seeds_.images != nullptr && seeds_.images->largest_coordinate() * 0x1p-53 * scale_ > bounds::image_rounding)
        return false;
    reach_ = radius;

    const std::size_t most = group_count_ * group_size + 16;
    for (auto* v : {&x_, &y_, &z_, &id_})
        if (v->size() < most) v->resize(2 * most);
    std::int32_t* const out[3] = {x_.data(), y_.data(), z_.data()};
    count_ = kernels_.to_window(
        {{seeds_.x.data(), seeds_.y.data(), seeds_.z.data()}, {groups_.data(), group_count_}, kept},
        {box, radius * radius * (1 + 1e-12), {origin_[0], origin_[1], origin_[2]}, scale_}, out, id_.data());
    for (int k = count_; k < count_ + 16; ++k) x_[k] = y_[k] = z_[k] = far_away, id_[k] = 0;
    base_weight_ = weight;
    return seeds_.weights.empty() || weigh();
}

std::array<std::int32_t, 3> Window::position(const std::array<double, 3>& x) const {
    std::array<std::int32_t, 3> result;
    for (std::size_t k = 0; k < 3; ++k) result[k] = static_cast<std::int32_t>(std::lrint((x[k] - origin_[k]) * scale_));
    return result;
}

bool Window::weigh() {
    weight_.resize(x_.size());
    min_weight_ = max_weight_ = 0;
    for (int i = 0; i < count_; ++i) {
        const std::int32_t id = id_[i];
        const bool image = seeds_.images != nullptr && seeds_.images->is_image(id);
        // Padding of the home's groups is far away and has no weight.
        const bool exists = static_cast<std::size_t>(id) < (image ? seeds_.images_end : seeds_.size());
        const auto seed = static_cast<std::size_t>(exists && image ? seeds_.images->home(id) : id);
        weight_[i] = exists ? weight(seeds_.weights[seed]) : 0;
        min_weight_ = std::min(min_weight_, weight_[i]);
        max_weight_ = std::max(max_weight_, weight_[i]);
    }
    for (int k = count_; k < count_ + 16; ++k) weight_[k] = 0;
    return double{max_weight_} - min_weight_ < widest_span;
}

}  // namespace votess::cpu

#include "walk/window.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/box.hpp"
#include "index/seed_images.hpp"
#include "walk/star_bounds.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t min_groups = 4;  // fewer say nothing about the surroundings
constexpr int max_tries = 12;
constexpr int max_heavier_tries = 4;
constexpr int max_bent_level = 0;           // the bend of the weights says little about large boxes
constexpr double widest_span = 1e28;        // of weights in squared units, which are floats
constexpr double smallest_extent = 1e-280;  // units would overflow

}  // namespace

// Level by level, so that tests of boxes overlap in the processor. The order of groups decides last digits at ties.
template <class Near>
bool Window::collect(std::size_t most, const Neighborhood& cells, Near near_boxes) {
    std::size_t nodes = 1;
    std::uint32_t *from = nodes_[0].data(), *to = nodes_[1].data();
    from[0] = 0;
    for (int level = hierarchy_.top_level(); level > 0; --level) {
        std::size_t next = 0;
        for (std::size_t i = 0; i < nodes; ++i) {
            if (next + box_fan > max_nodes) return false;
            next += kernels_.list_bits(near_boxes({level, from[i]}), from[i] * box_fan, to + next);
        }
        std::swap(from, to);
        nodes = next;
    }
    group_count_ = blocks_done_ = 0;
    while (nodes-- > 0) {
        if (cells.block_done(from[nodes])) {
            ++blocks_done_;
            continue;
        }
        group_count_ += kernels_.list_bits(near_boxes({0, from[nodes]}), from[nodes] * box_fan, &groups_[group_count_]);
        if (group_count_ > most) return false;
    }
    return true;
}

bool Window::collect(const Box& box, double radius, const WeightTilt* tilt, const Bent* bent,
                     const Neighborhood& cells) {
    const double square = radius * radius * (1 + 1e-12);
    if (tilt == nullptr)
        return collect(max_groups, cells, [&](const Node& node) {
            return kernels_.near_boxes(hierarchy_.block(node.level, node.index), box, square);
        });
    const double length = bent == nullptr ? 0.5 * radius : 0.5 * radius * bent->longest + bent->max_turned;
    const HeavierTest test(*tilt, length, 0, 0);
    return collect(max_heavier_groups, cells, [&](const Node& node) {
        const BoxBlock& boxes = hierarchy_.block(node.level, node.index);
        const WeightBlock& weights = hierarchy_.weight_bounds(node.level, node.index);
        return bent == nullptr || node.level > max_bent_level
                   ? kernels_.near_heavier(boxes, weights, box, test)
                   : bent_kernels_.near_bent(boxes, weights, bent->tilt, bent->bend,
                                             0.5 * radius / std::sqrt(bent->gain));
    });
}

Box Window::home_box(std::size_t home) const {
    const std::size_t first_group = home * home_groups;
    Box box = hierarchy_.box(0, first_group);
    for (std::size_t g = first_group + 1; g < std::min(first_group + home_groups, hierarchy_.count(0)); ++g)
        include(box, hierarchy_.box(0, g));
    return box;
}

bool Window::open(std::size_t home, const Box& box, double radius, const WeightTilt* tilt, const Neighborhood& cells,
                  const Bent* bent) {
    const WeightTilt* heavier = tilt;  // null if only near seeds are collected
    for (int tries = 0;; ++tries) {
        const bool all = collect(box, radius, heavier, bent, cells);
        if (!all && heavier != nullptr && tries == max_heavier_tries) {
            heavier = nullptr;
            continue;
        }
        if (tries == max_tries) {
            if (!all) return false;
            break;
        }
        if (!all)
            radius *= 0.7;
        else if (blocks_done_ == 0 && group_count_ < min_groups && group_count_ < hierarchy_.count(0))
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
    if (tilt != nullptr) {  // heavy seeds farther away
        Box all = box;
        for (std::size_t i = 0; i < group_count_; ++i) {
            const BoxBlock& boxes = hierarchy_.block(0, groups_[i] / box_fan);
            const std::size_t lane = groups_[i] % box_fan;
            for (std::size_t k = 0; k < 3; ++k) {
                all.lower[k] = std::min(all.lower[k], boxes.lower[k][lane]);
                all.upper[k] = std::max(all.upper[k], boxes.upper[k][lane]);
            }
        }
        for (std::size_t k = 0; k < 3; ++k)
            extent = std::max({extent, origin_[k] - all.lower[k], all.upper[k] - origin_[k]});
    }
    extent_ = extent;
    if (!(extent > smallest_extent && extent < 1 / smallest_extent)) return false;
    // Twice the extent, times the scale, is at most window_range * (1 - 2^-20), which covers the rounding of origin and
    // extent.
    scale_ = std::ldexp(1.0, 28 - std::ilogb(extent) - 1);
    // Images are rounded, seeds are not.
    if (seeds_.images != nullptr && seeds_.images->largest_coordinate() * 0x1p-53 * scale_ > bounds::image_rounding)
        return false;
    reach_ = radius;
    covered_ = heavier == tilt ? radius : 0;

    const std::size_t most = group_count_ * group_size + 16;
    for (auto* v : {&x_, &y_, &z_, &id_})
        if (v->size() < most) v->resize(2 * most);
    std::int32_t* const out[3] = {x_.data(), y_.data(), z_.data()};
    if (tilt != nullptr) weight_.resize(x_.size());
    const GroupSource source{{seeds_.x.data(), seeds_.y.data(), seeds_.z.data()},
                             seeds_.weights.data(),
                             {groups_.data(), group_count_},
                             kept};
    WindowFrame frame{box,         radius * radius * (1 + 1e-12), {origin_[0], origin_[1], origin_[2]}, scale_, tilt,
                      0.5 * radius};
    if (bent == nullptr) {
        count_ = kernels_.to_window(source, frame, out, id_.data(), weight_.data());
    } else {
        frame.length /= std::sqrt(bent->gain);
        count_ =
            bent_kernels_.to_bent_window(source, {frame, &bent->tilt, &bent->bend}, out, id_.data(), weight_.data());
    }
    for (int k = count_; k < count_ + 16; ++k) x_[k] = y_[k] = z_[k] = far_away, id_[k] = 0;
    if (tilt == nullptr) return true;
    const auto set_padding = [&](float weight) {
        for (std::size_t i = 0; i < kept; ++i) {
            const std::size_t begin = std::size_t{groups_[i]} * group_size, count = seeds_.group_end(begin) - begin;
            std::fill_n(weight_.begin() + static_cast<std::ptrdiff_t>(i * group_size + count), group_size - count,
                        weight);
        }
        std::fill_n(weight_.begin() + count_, 16, weight);
    };
    set_padding(0);
    const bool spanned = find_span();
    set_padding(no_weight);
    return spanned;
}

std::array<std::int32_t, 3> Window::position(const std::array<double, 3>& x) const {
    std::array<std::int32_t, 3> result;
    for (std::size_t k = 0; k < 3; ++k) result[k] = static_cast<std::int32_t>(std::lrint((x[k] - origin_[k]) * scale_));
    return result;
}

bool Window::find_span() {
    constexpr int lanes = 8;  // in vectors
    float least[lanes] = {}, most[lanes] = {};
    for (int i = 0; i < count_; i += lanes)
        for (int k = 0; k < lanes; ++k) {
            const float weight = weight_[i + k];
            least[k] = weight < least[k] ? weight : least[k];
            most[k] = weight > most[k] ? weight : most[k];
        }
    min_weight_ = *std::min_element(least, least + lanes);
    max_weight_ = *std::max_element(most, most + lanes);
    return double{max_weight_} - min_weight_ < widest_span;
}

}  // namespace votess::cpu

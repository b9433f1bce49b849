// The seeds around a home of some consecutive sorted seeds, as integers relative to the home. Differences of
// coordinates are exact to half a unit and have all bits of a float, however far the seeds lie from the origin.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "index/hierarchy.hpp"
#include "kernels/star_kernels.hpp"
#include "walk/neighborhood.hpp"

namespace votess::cpu {

class Window {
public:
    Window(const SortedSeeds& seeds, const Hierarchy& hierarchy, const StarKernels& kernels)
        : seeds_(seeds), hierarchy_(hierarchy), kernels_(kernels) {}

    static constexpr std::size_t home_groups = 2;
    static constexpr std::size_t home_seeds = home_groups * group_size;

    static constexpr std::size_t no_home = ~std::size_t{0} - 1;

    // Collects all seeds nearer to a box than about `radius`, except those of groups that are done. box: of home `home`
    // (seeds home * home_seeds and on), of one of its seeds, or any box for no_home. weight: of a seed that matters;
    // weights are relative to it. Returns false when no window can represent them.
    bool open(std::size_t home, const Box& box, double radius, double weight, const Neighborhood& cells);

    [[nodiscard]] Box home_box(std::size_t home) const;
    [[nodiscard]] WindowSeeds seeds() const {
        return {x_.data(), y_.data(), z_.data(), id_.data(), seeds_.weights.empty() ? nullptr : weight_.data(), count_};
    }
    [[nodiscard]] double reach() const { return reach_; }  // complete within this distance of the home's box
    [[nodiscard]] double scale() const { return scale_; }  // units per length, a power of two
    [[nodiscard]] std::array<std::int32_t, 3> position(std::size_t seed) const {
        const std::size_t i = place(seed);
        return {x_[i], y_[i], z_[i]};
    }
    [[nodiscard]] std::array<std::int32_t, 3> position(const std::array<double, 3>& x) const;
    // In a power diagram: a weight relative to the window's base, and the span of the weights and `own`, in squared
    // units.
    [[nodiscard]] float weight(double weight) const {
        return static_cast<float>((weight - base_weight_) * scale_ * scale_);
    }
    [[nodiscard]] double weight_span(float own) const {
        return double{std::max(max_weight_, own)} - std::min(min_weight_, own);
    }
    // Whether a seed of the home is present. It is not if squares of distances underflow.
    [[nodiscard]] bool holds(std::size_t seed) const { return place(seed) < static_cast<std::size_t>(count_); }
    // Removes a seed of the home from the candidates if it is present, and restores it.
    void hide(std::size_t seed) {
        if (const std::size_t i = place(seed); i < x_.size()) x_[i] = far_away;
    }
    void show(std::size_t seed, std::int32_t x) { x_[place(seed)] = x; }

private:
    [[nodiscard]] std::size_t place(std::size_t seed) const {
        return home_places_[seed / group_size % home_groups] + seed % group_size;
    }
    // Returns false when the weights differ too much for floats.
    bool weigh();
    // Returns false when more than `max_groups` groups are that near.
    bool collect(const Box& box, double distance_squared);

    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    const StarKernels& kernels_;
    static constexpr std::size_t max_groups = 160;  // beyond it a second search is cheaper
    struct Node {
        std::int32_t level;
        std::uint32_t index;
    };
    std::array<Node, Hierarchy::max_nodes> stack_;
    std::array<std::uint32_t, max_groups + 2 * box_fan> groups_;
    std::size_t group_count_ = 0;
    std::vector<std::int32_t> x_, y_, z_, id_;
    std::vector<float> weight_;
    double base_weight_ = 0;
    float min_weight_ = 0, max_weight_ = 0;
    int count_ = 0;
    std::array<std::size_t, home_groups> home_places_{};  // of the first seeds of the home's groups
    std::array<double, 3> origin_{};
    double reach_ = 0, scale_ = 1;
};

}  // namespace votess::cpu

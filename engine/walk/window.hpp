// The seeds around a home of some consecutive sorted seeds, as integers relative to the home. Differences of
// coordinates are exact to half a unit and have all bits of a float, however far the seeds lie from the origin.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "index/hierarchy.hpp"
#include "kernels/star_kernels.hpp"
#include "kernels/weight_bend.hpp"
#include "walk/neighborhood.hpp"

namespace votess::cpu {

class Window {
public:
    static_assert(Neighborhood::block_groups == Hierarchy::fan);

    Window(const SortedSeeds& seeds, const Hierarchy& hierarchy, const StarKernels& kernels)
        : seeds_(seeds), hierarchy_(hierarchy), kernels_(kernels), bent_kernels_(bent_kernels(kernels.name)) {}

    static constexpr std::size_t home_groups = Hierarchy::slope_groups;
    static constexpr std::size_t home_seeds = home_groups * group_size;

    static constexpr std::size_t no_home = ~std::size_t{0} - 1;

    // Where weights bend, each seed of the home is moved by the slope at its place, and distances are from there. A
    // plane n.X = h is h / |n|_G away, with G = A / gain and det G = 1. It cuts off X only if that is less than the
    // length of X by the inverse of G.
    struct Bent {
        WeightTilt tilt;  // with the least rho
        WeightBend bend;
        double max_turned = 0;  // largest difference from the tilt in the move of a seed of the home
        double gain = 1;
        double metric[3][3], inverse[3][3];
        double longest = 1, longest_inverse = 1;  // |n|_G of a vector of length 1, at most, and the same by the inverse
        double stretch = 1;                       // bound on the ratio of squares of |n|_G of vectors of length 1
    };

    // Collects all seeds whose planes may come nearer to a seed in a box than about radius / 2, except those of groups
    // that are done. Without weights these are the seeds nearer than the radius. box: of home `home` (seeds home *
    // home_seeds and on), of one of its seeds, or any box for no_home. tilt: null without weights. Returns false when
    // no window can represent them. bent: null where weights hardly bend.
    bool open(std::size_t home, const Box& box, double radius, const WeightTilt* tilt, const Neighborhood& cells,
              const Bent* bent);

    [[nodiscard]] Box home_box(std::size_t home) const;
    [[nodiscard]] WindowSeeds seeds() const {
        return {x_.data(), y_.data(), z_.data(), id_.data(), seeds_.weights.empty() ? nullptr : weight_.data(), count_};
    }
    // Planes nearer than half of this to a seed are wanted, where weights bend by the lengths of the metric.
    [[nodiscard]] double reach() const { return reach_; }
    // Planes nearer than half of this are all there, those of far heavy seeds too.
    [[nodiscard]] double covered() const { return covered_; }
    [[nodiscard]] double scale() const { return scale_; }  // units per length, a power of two
    [[nodiscard]] std::array<std::int32_t, 3> position(std::size_t seed) const {
        const std::size_t i = place(seed);
        return {x_[i], y_[i], z_[i]};
    }
    [[nodiscard]] std::array<std::int32_t, 3> position(const std::array<double, 3>& x) const;
    // In a power diagram: a residual, and the span of those of the window and `own`, in squared units.
    [[nodiscard]] float weight(double residual) const { return static_cast<float>(residual * scale_ * scale_); }
    [[nodiscard]] double weight_span(float own) const {
        return double{std::max(max_weight_, own)} - std::min(min_weight_, own);
    }
    [[nodiscard]] double extent() const {
        return extent_ * scale_;
    }  // bound on distances from the origin along an axis
    // Whether a seed of the home is present. It is not if squares of distances underflow.
    [[nodiscard]] bool holds(std::size_t seed) const { return place(seed) < static_cast<std::size_t>(count_); }
    // Removes a seed of the home from the candidates if it is present, and restores it.
    void hide(std::size_t seed) {
        const std::size_t i = place(seed);
        if (i >= x_.size()) return;
        x_[i] = far_away;
        if (i < weight_.size()) weight_[i] = no_weight;
    }
    void show(std::size_t seed, std::int32_t x, float weight) {
        const std::size_t i = place(seed);
        x_[i] = x;
        if (i < weight_.size()) weight_[i] = weight;
    }

private:
    static constexpr float no_weight = -std::numeric_limits<float>::infinity();  // of a seed that is not a candidate

    [[nodiscard]] std::size_t place(std::size_t seed) const {
        return home_places_[seed / group_size % home_groups] + seed % group_size;
    }
    // Returns false when the weights differ too much for floats.
    bool find_span();
    // Returns false when more than `max_groups` groups are that near. Skips and counts blocks that are done.
    bool collect(const Box& box, double radius, const WeightTilt* tilt, const Bent* bent, const Neighborhood& cells);
    template <class Near>
    bool collect(std::size_t most, const Neighborhood& cells, Near near);

    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    const StarKernels& kernels_;
    const BentKernels& bent_kernels_;
    static constexpr std::size_t max_groups = 160;  // beyond it a second search is cheaper
    static constexpr std::size_t max_heavier_groups = 512;
    struct Node {
        std::int32_t level;
        std::uint32_t index;
    };
    static constexpr std::size_t max_nodes = 1024;  // of a level
    std::array<std::array<std::uint32_t, max_nodes>, 2> nodes_;
    std::array<std::uint32_t, max_heavier_groups + 2 * box_fan> groups_;
    std::size_t group_count_ = 0, blocks_done_ = 0;
    std::vector<std::int32_t> x_, y_, z_, id_;
    std::vector<float> weight_;
    double extent_ = 0;
    float min_weight_ = 0, max_weight_ = 0;
    int count_ = 0;
    std::array<std::size_t, home_groups> home_places_{};  // of the first seeds of the home's groups
    std::array<double, 3> origin_{};
    double reach_ = 0, covered_ = 0, scale_ = 1;
};

}  // namespace votess::cpu

// An implicit tree of bounding boxes over the sorted seeds and their images. Level 0 has one box for each group, each
// box of level k+1 covers eight of level k, the top level has one. Seeds follow a Hilbert curve, so boxes are compact
// at any density. Weights are stored by box, so that one heavy seed does not widen every search, and as an affine
// bound, so that weights that vary smoothly do not widen it either.
#pragma once

#include <cstdint>
#include <vector>

#include "core/buffer.hpp"
#include "core/thread_pool.hpp"
#include "index/sort.hpp"
#include "kernels/star_kernels.hpp"

namespace votess::cpu {

class Hierarchy {
public:
    static constexpr std::size_t fan = box_fan;
    static_assert(fan == 8);  // first_seed()
    // Bound on the pending nodes of a depth-first search, in a tree of any size.
    static constexpr std::size_t max_nodes = 256;
    static constexpr std::size_t max_levels = 12;  // seeds have numbers of 31 bits

    void build(const SortedSeeds& seeds, ThreadPool& pool);

    // Calls visit(memory) for its arrays.
    template <class Visit>
    void for_memory(const Visit& visit) {
        for (auto& level : levels_) visit(level.memory());
        for (auto& level : weights_) visit(level.memory());
        for (auto& level : rests_) visit(level.memory());
        for (auto& level : bounds_) visit(level.memory());
    }

    [[nodiscard]] int top_level() const { return static_cast<int>(counts_.size()) - 1; }
    [[nodiscard]] std::size_t count(int level) const { return counts_[level]; }
    // Boxes 8 index .. 8 index + 7 of a level: the children of box `index` one level up.
    [[nodiscard]] const BoxBlock& block(int level, std::size_t index) const { return levels_[level][index]; }
    [[nodiscard]] static std::size_t first_seed(int level, std::size_t node) {
        return (node * group_size) << (3 * level);
    }
    [[nodiscard]] Box box(int level, std::size_t node) const {
        const BoxBlock& b = levels_[level][node / fan];
        const std::size_t i = node % fan;
        return {{b.lower[0][i], b.lower[1][i], b.lower[2][i]}, {b.upper[0][i], b.upper[1][i], b.upper[2][i]}};
    }

    [[nodiscard]] bool has_weights() const { return has_weights_; }
    // 0 without weights.
    [[nodiscard]] double largest_weight(int level, std::size_t node) const {
        return has_weights_ ? weights_[static_cast<std::size_t>(level)][node] : 0;
    }
    // If the weights follow a paraboloid.
    [[nodiscard]] double largest_rest(int level, std::size_t node) const {
        return rests_[static_cast<std::size_t>(level)][node];
    }
    [[nodiscard]] double largest_weight_of_block(int level, std::size_t index) const {
        return level == top_level() ? largest_weight(level, 0) : largest_weight(level + 1, index);
    }

    // Returns the bounds of a block's boxes, in a power diagram.
    [[nodiscard]] const WeightBlock& weight_bounds(int level, std::size_t index) const { return bounds_[level][index]; }
    // Number of consecutive groups whose bounds have the same slope.
    static constexpr std::size_t slope_groups = 2;

private:
    void fill(const SortedSeeds& seeds, std::size_t level, std::size_t index);
    // Sets the largest of some values below a node.
    void fill_largest(const SortedSeeds& seeds, const std::vector<double>& values, std::size_t level, std::size_t node,
                      std::vector<Buffer<double>>& out) const;
    void bound_weights(const SortedSeeds& seeds, std::size_t level, std::size_t index);

    std::vector<Buffer<BoxBlock>> levels_;  // levels beyond counts_ keep memory for the next build
    // In a power diagram.
    std::vector<Buffer<double>> weights_;  // by level and box
    std::vector<Buffer<double>> rests_;    // the same, see Lift
    std::vector<Buffer<WeightBlock>> bounds_;
    bool has_weights_ = false;
    std::vector<std::size_t> counts_;
};

}  // namespace votess::cpu

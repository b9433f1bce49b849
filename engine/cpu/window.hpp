// The seeds around a group of consecutive sorted seeds, as integers relative to the group: differences of coordinates
// are exact to half a unit and have all bits of a float, however far from the origin the seeds lie.
#pragma once

#include <cstdint>
#include <vector>

#include "cpu/hierarchy.hpp"
#include "cpu/neighborhood.hpp"
#include "cpu/star_kernels.hpp"

namespace votess::cpu {

class Window {
public:
    Window(const SortedSeeds& seeds, const Hierarchy& hierarchy, const StarKernels& kernels)
        : seeds_(seeds), hierarchy_(hierarchy), kernels_(kernels) {}

    // Collects all seeds nearer to the group's box than about `radius`, but for those of groups that are done. False
    // when the group spans no representable window.
    bool open(std::size_t group, double radius, const Neighborhood& cells);

    [[nodiscard]] WindowSeeds seeds() const { return {x_.data(), y_.data(), z_.data(), id_.data(), count_}; }
    [[nodiscard]] double reach() const { return reach_; }  // complete within this distance of the group's box
    [[nodiscard]] double scale() const { return scale_; }  // units per length, a power of two
    [[nodiscard]] std::array<std::int32_t, 3> position(std::size_t seed) const {
        const std::size_t i = home_ + seed % group_size;
        return {x_[i], y_[i], z_[i]};
    }
    // Takes a seed of the group out of the candidates, and back again.
    void hide(std::size_t seed) { x_[home_ + seed % group_size] = far_away; }
    void show(std::size_t seed, std::int32_t x) { x_[home_ + seed % group_size] = x; }

private:
    // False when more seeds than `most` are that near.
    bool collect(std::size_t group, const BoundingBox& home, double distance_squared, std::size_t most,
                 const Neighborhood& cells);

    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    const StarKernels& kernels_;
    std::vector<std::uint32_t> groups_;
    struct Node {
        std::int32_t level;
        std::uint32_t index;
    };
    std::vector<Node> stack_;
    std::vector<std::int32_t> x_, y_, z_, id_;
    int count_ = 0;
    std::size_t home_ = 0;  // place of the group's first seed
    double reach_ = 0, scale_ = 1;
};

}  // namespace votess::cpu

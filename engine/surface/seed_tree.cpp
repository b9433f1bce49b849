#include "surface/seed_tree.hpp"

#include <numeric>

#include "core/progress.hpp"
#include "core/vector3.hpp"

namespace votess::surface {
namespace {

constexpr std::uint32_t leaf_seeds = 8;

}  // namespace

SeedTree::SeedTree(std::span<const exact::Point> seeds, std::span<const double> weights) : order_(seeds.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    const auto seed = [&](std::int32_t i) -> const exact::Point& { return seeds[static_cast<std::size_t>(i)]; };
    const auto weight = [&](std::int32_t i) { return weights.empty() ? 0 : weights[static_cast<std::size_t>(i)]; };
    std::ranges::sort(order_, [&](std::int32_t i, std::int32_t j) {
        if (seed(i) != seed(j)) return seed(i) < seed(j);
        return weight(i) != weight(j) ? weight(i) > weight(j) : i < j;
    });
    order_.erase(
        std::unique(order_.begin(), order_.end(), [&](std::int32_t i, std::int32_t j) { return seed(i) == seed(j); }),
        order_.end());
    nodes_.push_back({{}, {}, 0, 0, static_cast<std::uint32_t>(order_.size()), 0});
    for (std::uint32_t at = 0; at < nodes_.size(); ++at) {
        if (at % 1024 == 0) check_stop();
        split(at, seeds, weights);
    }
    places_.reserve(order_.size());
    for (const std::int32_t id : order_) places_.push_back(seeds[static_cast<std::size_t>(id)]);
}

// Finds the box of a node and, unless it is a leaf, makes its children.
void SeedTree::split(std::uint32_t at, std::span<const exact::Point> seeds, std::span<const double> weights) {
    const auto seed = [&](std::int32_t i) -> const exact::Point& { return seeds[static_cast<std::size_t>(i)]; };
    const auto [begin, end] = std::pair(nodes_[at].begin, nodes_[at].end);
    exact::Point lower = seed(order_[begin]), upper = lower;
    double weight = weights.empty() ? 0 : weights[static_cast<std::size_t>(order_[begin])];
    for (std::uint32_t i = begin; i < end; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            lower[k] = std::min(lower[k], seed(order_[i])[k]);
            upper[k] = std::max(upper[k], seed(order_[i])[k]);
        }
        if (!weights.empty()) weight = std::max(weight, weights[static_cast<std::size_t>(order_[i])]);
    }
    nodes_[at] = {lower, upper, weight, begin, end, 0};
    if (end - begin <= leaf_seeds) return;
    const Vector3 size = minus(upper, lower);
    const auto axis = static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                     [&](std::int32_t i, std::int32_t j) {
                         return seed(i)[axis] != seed(j)[axis] ? seed(i)[axis] < seed(j)[axis] : i < j;
                     });
    nodes_[at].child = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({{}, {}, 0, begin, half, 0});
    nodes_.push_back({{}, {}, 0, half, end, 0});
}

}  // namespace votess::surface

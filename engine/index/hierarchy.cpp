#include "index/hierarchy.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "core/arithmetic.hpp"
#include "index/seed_images.hpp"

namespace votess::cpu {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t task_blocks = 512;

double largest_of(const SortedSeeds& seeds, std::size_t begin, std::size_t end) {
    double largest = -infinity;
    for (std::size_t id = begin; id < end; ++id) {
        const std::size_t home =
            seeds.images == nullptr ? id : static_cast<std::size_t>(seeds.images->home(static_cast<std::int32_t>(id)));
        largest = std::max(largest, seeds.weights[home]);
    }
    return largest;
}

}  // namespace

void Hierarchy::build(const SortedSeeds& seeds, ThreadPool& pool) {
    counts_.clear();
    for (std::size_t count = seeds.places() / group_size;; count = ceil_div(count, fan)) {
        counts_.push_back(count);
        if (count <= 1) break;
    }
    while (levels_.size() < counts_.size()) levels_.emplace_back(Buffer<BoxBlock>::Pages::huge);
    has_weights_ = !seeds.weights.empty();
    if (has_weights_) weights_.resize(std::max(weights_.size(), counts_.size()));
    for (std::size_t level = 0; level < counts_.size(); ++level) {
        const std::size_t blocks = std::max<std::size_t>(1, ceil_div(counts_[level], fan));
        levels_[level].resize_uninitialized(blocks);
        if (has_weights_) weights_[level].resize_uninitialized(counts_[level]);
        const auto task = [&](std::size_t index, unsigned) {
            for (std::size_t b = index * task_blocks; b < std::min(blocks, (index + 1) * task_blocks); ++b)
                fill(seeds, level, b);
        };
        pool.run(ceil_div(blocks, task_blocks), std::cref(task));  // by reference: no allocation
    }
}

void Hierarchy::fill(const SortedSeeds& seeds, std::size_t level, std::size_t index) {
    BoxBlock& block = levels_[level][index];
    for (std::size_t i = 0; i < fan; ++i) {
        const std::size_t node = index * fan + i;
        for (int k = 0; k < 3; ++k) block.lower[k][i] = infinity, block.upper[k][i] = -infinity;
        if (node >= counts_[level]) continue;
        if (level == 0) {
            const Buffer<double>* coordinates[3] = {&seeds.x, &seeds.y, &seeds.z};
            const std::size_t begin = node * group_size, end = seeds.group_end(begin);
            for (int k = 0; k < 3; ++k) {
                const auto [least, most] =
                    std::minmax_element(coordinates[k]->data() + begin, coordinates[k]->data() + end);
                block.lower[k][i] = *least, block.upper[k][i] = *most;
            }
            if (has_weights_) weights_[0][node] = largest_of(seeds, begin, end);
        } else {
            const BoxBlock& below = levels_[level - 1][node];
            for (int k = 0; k < 3; ++k) {
                block.lower[k][i] = *std::min_element(below.lower[k], below.lower[k] + fan);
                block.upper[k][i] = *std::max_element(below.upper[k], below.upper[k] + fan);
            }
            if (has_weights_) {
                const double* weights = weights_[level - 1].data() + node * fan;
                weights_[level][node] =
                    *std::max_element(weights, weights + std::min(fan, counts_[level - 1] - node * fan));
            }
        }
    }
}

}  // namespace votess::cpu

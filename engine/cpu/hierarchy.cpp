#include "cpu/hierarchy.hpp"

#include <algorithm>
#include <limits>

namespace votess::cpu {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t task_blocks = 512;

std::size_t divide_up(std::size_t a, std::size_t b) {
    return (a + b - 1) / b;
}

void put(BoxBlock& block, std::size_t i, const double* lower, const double* upper) {
    for (int k = 0; k < 3; ++k) {
        block.lower[k][i] = lower[k];
        block.upper[k][i] = upper[k];
    }
}

}  // namespace

void Hierarchy::build(const SortedSeeds& seeds, ThreadPool& pool) {
    constexpr double none_lower[3] = {infinity, infinity, infinity};
    constexpr double none_upper[3] = {-infinity, -infinity, -infinity};
    counts_.clear();
    for (std::size_t count = divide_up(seeds.size(), group_size);; count = divide_up(count, fan)) {
        counts_.push_back(count);
        if (count <= 1) break;
    }
    levels_.resize(counts_.size());
    for (std::size_t level = 0; level < levels_.size(); ++level) {
        auto& blocks = levels_[level];
        blocks.resize(std::max<std::size_t>(1, divide_up(counts_[level], fan)));
        pool.run(divide_up(blocks.size(), task_blocks), [&](std::size_t task, unsigned) {
            for (std::size_t b = task * task_blocks; b < std::min(blocks.size(), (task + 1) * task_blocks); ++b)
                for (std::size_t i = 0; i < fan; ++i) {
                    const std::size_t node = b * fan + i;
                    double lower[3], upper[3];
                    std::copy_n(none_lower, 3, lower);
                    std::copy_n(none_upper, 3, upper);
                    if (node >= counts_[level]) {
                        // as it is
                    } else if (level == 0) {
                        for (std::size_t s = node * group_size; s < std::min(seeds.size(), (node + 1) * group_size);
                             ++s) {
                            const double p[3] = {seeds.x[s], seeds.y[s], seeds.z[s]};
                            for (int k = 0; k < 3; ++k) {
                                lower[k] = std::min(lower[k], p[k]);
                                upper[k] = std::max(upper[k], p[k]);
                            }
                        }
                    } else {
                        const BoxBlock& below = levels_[level - 1][node];
                        for (int k = 0; k < 3; ++k) {
                            lower[k] = *std::min_element(below.lower[k], below.lower[k] + fan);
                            upper[k] = *std::max_element(below.upper[k], below.upper[k] + fan);
                        }
                    }
                    put(blocks[b], i, lower, upper);
                }
        });
    }
}

}  // namespace votess::cpu

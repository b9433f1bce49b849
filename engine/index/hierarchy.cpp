#include "index/hierarchy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/arithmetic.hpp"
#include "index/seed_images.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t task_blocks = 512;

constexpr double slope_gain = 0.6;     // a slope must lower the span of the weights to this part
constexpr double max_moved = 256;      // twice how far a slope may move cells, in mean distances from the center
constexpr double bound_slack = 4e-15;  // of the terms of a bound

using Slope = std::array<double, 3>;

// Returns the slope of the weights of some seeds by least squares, or 0 if it explains little of them.
Slope fit_slope(const SortedSeeds& seeds, std::size_t begin, std::size_t end) {
    constexpr double ridge = 1e-3;  // of the mean square, for seeds in a plane or on a line
    const double* const at[3] = {seeds.x.data(), seeds.y.data(), seeds.z.data()};
    const double base = seeds.weights[begin], count = static_cast<double>(end - begin);
    double mean[4] = {}, low = 0, high = 0;
    for (std::size_t s = begin; s < end; ++s) {
        for (int k = 0; k < 3; ++k) mean[k] += at[k][s] - at[k][begin];
        const double weight = seeds.weights[s] - base;
        mean[3] += weight;
        low = std::min(low, weight), high = std::max(high, weight);
    }
    for (double& m : mean) m /= count;
    double m[3][4] = {};
    for (std::size_t s = begin; s < end; ++s) {
        double d[4];
        for (int k = 0; k < 3; ++k) d[k] = at[k][s] - at[k][begin] - mean[k];
        d[3] = seeds.weights[s] - base - mean[3];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 4; ++j) m[i][j] += d[i] * d[j];
    }
    const double spread = m[0][0] + m[1][1] + m[2][2], more = ridge * spread;
    for (int i = 0; i < 3; ++i) m[i][i] += more;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            if (j == i) continue;
            const double by = m[j][i] / m[i][i];
            for (int k = i; k < 4; ++k) m[j][k] -= by * m[i][k];
        }
    Slope slope;
    for (int i = 0; i < 3; ++i) slope[i] = m[i][3] / m[i][i];
    double least = infinity, most = -infinity;
    for (std::size_t s = begin; s < end; ++s) {
        double rest = seeds.weights[s] - base;
        for (int k = 0; k < 3; ++k) rest -= slope[k] * (at[k][s] - at[k][begin]);
        least = std::min(least, rest), most = std::max(most, rest);
    }
    const double span = most - least;  // less than 0 if the slope is NaN
    const double steepness = slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2];
    const bool far = !(steepness * count < max_moved * max_moved * spread);
    return span >= 0 && span < slope_gain * (high - low) && !far ? slope : Slope{};
}

Slope center_of(const BoxBlock& boxes, std::size_t i) {
    Slope center;
    for (int k = 0; k < 3; ++k) center[k] = 0.5 * (boxes.lower[k][i] + boxes.upper[k][i]);
    return center;
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
    if (has_weights_) {
        weights_.resize(std::max(weights_.size(), counts_.size()));
        bounds_.resize(std::max(bounds_.size(), counts_.size()));
        rests_.resize(weights_.size());
    }
    for (std::size_t level = 0; level < counts_.size(); ++level) {
        const std::size_t blocks = std::max<std::size_t>(1, ceil_div(counts_[level], fan));
        levels_[level].resize_uninitialized(blocks);
        if (has_weights_) {
            weights_[level].resize_uninitialized(counts_[level]);
            bounds_[level].resize_uninitialized(blocks);
            if (seeds.lift.exists()) rests_[level].resize_uninitialized(counts_[level]);
        }
        const auto task = [&](std::size_t index, unsigned) {
            for (std::size_t b = index * task_blocks; b < std::min(blocks, (index + 1) * task_blocks); ++b)
                if (fill(seeds, level, b); has_weights_) bound_weights(seeds, level, b);
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
        } else {
            const BoxBlock& below = levels_[level - 1][node];
            for (int k = 0; k < 3; ++k) {
                block.lower[k][i] = *std::min_element(below.lower[k], below.lower[k] + fan);
                block.upper[k][i] = *std::max_element(below.upper[k], below.upper[k] + fan);
            }
        }
        if (has_weights_) fill_largest(seeds, seeds.weights, level, node, weights_);
        if (seeds.lift.exists()) fill_largest(seeds, seeds.lift.rests, level, node, rests_);
    }
}

void Hierarchy::fill_largest(const SortedSeeds& seeds, const std::vector<double>& values, std::size_t level,
                             std::size_t node, std::vector<Buffer<double>>& out) const {
    if (level == 0) {
        const std::size_t begin = node * group_size;
        out[0][node] = *std::max_element(values.begin() + static_cast<std::ptrdiff_t>(begin),
                                         values.begin() + static_cast<std::ptrdiff_t>(seeds.group_end(begin)));
    } else {
        const double* below = out[level - 1].data() + node * fan;
        out[level][node] = *std::max_element(below, below + std::min(fan, counts_[level - 1] - node * fan));
    }
}

// The slope of a group is fitted to its seeds and those of its sibling, that of another box is the mean of its parts.
void Hierarchy::bound_weights(const SortedSeeds& seeds, std::size_t level, std::size_t index) {
    const BoxBlock& boxes = levels_[level][index];
    WeightBlock& out = bounds_[level][index];
    Slope slope{};
    for (std::size_t i = 0; i < fan; ++i) {
        const std::size_t node = index * fan + i;
        if (node >= counts_[level]) {
            out.top[i] = -infinity;
            for (auto& along : out.slope) along[i] = 0;
            out.at_zero[i] = -infinity;
            out.size[i] = 0;
            continue;
        }
        const Slope center = center_of(boxes, i);
        double top = -infinity, size = 0;
        const auto add = [&](double weight, const Slope& at) {
            double rest = weight, terms = std::abs(weight);
            for (int k = 0; k < 3; ++k) {
                const double by = slope[k] * (at[k] - center[k]);
                rest -= by;
                terms += std::abs(by);
            }
            top = std::max(top, rest);
            size = std::max(size, terms);
        };
        if (level == 0) {
            const std::size_t begin = node * group_size, end = seeds.group_end(begin);
            if (node % slope_groups == 0) {
                const std::size_t next = begin + group_size;
                const bool both = node + 1 < counts_[0] && (begin < seeds.size()) == (next < seeds.size());
                slope = fit_slope(seeds, begin, both ? seeds.group_end(next) : end);
            } else if ((begin - group_size < seeds.size()) != (begin < seeds.size())) {
                slope = fit_slope(seeds, begin, end);
            }
            for (std::size_t s = begin; s < end; ++s) add(seeds.weights[s], {seeds.x[s], seeds.y[s], seeds.z[s]});
        } else {
            const BoxBlock& below = levels_[level - 1][node];
            const WeightBlock& parts = bounds_[level - 1][node];
            const std::size_t count = std::min(fan, counts_[level - 1] - node * fan);
            for (int k = 0; k < 3; ++k) {
                slope[k] = 0;
                for (std::size_t c = 0; c < count; ++c) slope[k] += parts.slope[k][c] / static_cast<double>(count);
            }
            for (std::size_t c = 0; c < count; ++c) {
                double most = parts.top[c];
                for (int k = 0; k < 3; ++k)
                    most += std::abs(parts.slope[k][c] - slope[k]) * 0.5 * (below.upper[k][c] - below.lower[k][c]);
                add(most, center_of(below, c));
            }
        }
        top += bound_slack * size;
        if (const double largest = weights_[level][node]; level > 0 && !(top < largest)) top = largest, slope = {};
        out.top[i] = top;
        for (int k = 0; k < 3; ++k) out.slope[k][i] = slope[k];
        out.extend(i, box(static_cast<int>(level), node));
    }
}

}  // namespace votess::cpu

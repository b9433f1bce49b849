#include "cpu/kept_order.hpp"

#include <algorithm>

#include "cpu/sort_grid.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t gather_task = 32768;  // seeds per parallel task
// Mean growth of what a group costs in searches before sorting pays: the number of windows that its box reaches into.
constexpr double most_growth = 1.03;
constexpr double window_extent = 2;  // of a window, in boxes of groups

template <class At>
double extent_of_group(std::size_t group, const At& at) {
    Bounds bounds;
    for (std::size_t s = group * group_size; s < (group + 1) * group_size; ++s) {
        const auto [x, y, z] = at(s);
        bounds.add(x, y, z);
    }
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += bounds.upper[k] - bounds.lower[k];
    return sum;
}

template <class Real>
void gather_from(std::span<const Real> points, double scale, ThreadPool& pool, SortedSeeds& seeds) {
    constexpr std::size_t lookahead = 24;
    const std::size_t count = seeds.size();
    pool.run((count + gather_task - 1) / gather_task, [&](std::size_t task, unsigned) {
        const std::size_t end = std::min(count, (task + 1) * gather_task);
        for (std::size_t s = task * gather_task; s < end; ++s) {
            const auto next = static_cast<std::size_t>(seeds.input[std::min(s + lookahead, end - 1)]);
            __builtin_prefetch(&points[3 * next]);
            const Real* p = &points[3 * static_cast<std::size_t>(seeds.input[s])];
            seeds.x[s] = p[0] * scale, seeds.y[s] = p[1] * scale, seeds.z[s] = p[2] * scale;
        }
    });
}

}  // namespace

std::size_t KeptOrder::sampled_group(std::size_t sample, std::size_t groups) const {
    return sample * groups / extents_.size();
}

void KeptOrder::keep(const SortedSeeds& seeds, double scale) {
    const std::size_t groups = seeds.size() / group_size;
    extents_.resize(std::min(groups, most_samples));
    for (std::size_t k = 0; k < extents_.size(); ++k)
        extents_[k] = extent_of_group(sampled_group(k, groups),
                                      [&](std::size_t s) {
                                          return std::array{seeds.x[s], seeds.y[s], seeds.z[s]};
                                      }) /
                      scale;
}

bool KeptOrder::fits(const Points& points, const SortedSeeds& order) const {
    const std::size_t groups = order.size() / group_size;
    double sum = 0;
    for (std::size_t k = 0; k < extents_.size(); ++k) {
        const double extent = extent_of_group(sampled_group(k, groups), [&](std::size_t s) {
            const auto i = static_cast<std::size_t>(order.input[s]);
            return std::array{points[3 * i], points[3 * i + 1], points[3 * i + 2]};
        });
        const double growth = (extent / extents_[k] + window_extent) / (1 + window_extent);
        sum += growth * growth * growth;
    }
    return sum <= most_growth * static_cast<double>(extents_.size());
}

void KeptOrder::gather(const Points& points, double scale, ThreadPool& pool, SortedSeeds& seeds) {
    if (points.f32.empty())
        gather_from(points.f64, scale, pool, seeds);
    else
        gather_from(points.f32, scale, pool, seeds);
}

}  // namespace votess::cpu

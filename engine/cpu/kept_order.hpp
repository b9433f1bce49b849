// The order of the seeds of the last job, used again for the same seeds after they have moved a little.
#pragma once

#include <cstddef>
#include <vector>

#include "cpu/sorted_seeds.hpp"
#include "engine.hpp"
#include "thread_pool.hpp"

namespace votess::cpu {

// Thrown while cells are built in a kept order that they need sorted anew: two seeds are equal, which only sorting
// settles, or cells are so hard that all seeds are triangulated, which must not meet equal ones.
struct NeedsSort {};

class KeptOrder {
public:
    // seeds: just sorted; their coordinates are those of the input times scale.
    void keep(const SortedSeeds& seeds, double scale);
    // Whether consecutive seeds of that order, without duplicates, are still neighbors in space. Looks at a sample.
    [[nodiscard]] bool fits(const Points& points, const SortedSeeds& order) const;
    // Puts new coordinates in the place of the old ones. Equal seeds are not found.
    static void gather(const Points& points, double scale, ThreadPool& pool, SortedSeeds& seeds);

private:
    static constexpr std::size_t most_samples = 1024;  // groups

    [[nodiscard]] std::size_t sampled_group(std::size_t sample, std::size_t groups) const;

    std::vector<double> extents_;  // of the boxes of some groups when they were sorted: sums of their sides, unscaled
};

}  // namespace votess::cpu

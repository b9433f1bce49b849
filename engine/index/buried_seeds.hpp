// Seeds of a power diagram that have no cell since heavier ones nearby have less power wherever their cells may be.
// Where weights differ by far more than the square of the spacing these are most seeds. Without them windows, images
// and searches hold few seeds that do not matter.
#pragma once

#include <cstdint>
#include <vector>

#include "core/thread_pool.hpp"
#include "domain/domain.hpp"
#include "index/sorted_seeds.hpp"

namespace votess::cpu {

// Removes some of these from sorted seeds that have no images yet, and appends their input indices to `buried`. Which
// ones does not depend on the number of threads. only_most: none, unless these are most seeds.
void drop_buried(const Domain& domain, ThreadPool& pool, bool only_most, SortedSeeds& seeds,
                 std::vector<std::int32_t>& buried);

}  // namespace votess::cpu

// Sorts the seeds of a job but for those outside of the domain, which have no cell.
#pragma once

#include <span>

#include "index/sort.hpp"
#include "input/job.hpp"

namespace votess::cpu {

// outside: as in the job. Indices in `out` are those of the points; see SeedSorter::sort() for the rest.
void sort_inside(const Points& points, double scale, unsigned resolution, std::span<const CellStatus> outside,
                 SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out);

}  // namespace votess::cpu

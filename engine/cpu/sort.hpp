// Seeds in memory order = order in space. The seeds are binned in a grid whose blocks follow a Hilbert curve; a block
// that stays crowded is binned again within its own bounds, so any clustering is resolved. Equal seeds always share a
// block, which is how duplicates are found.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "thread_pool.hpp"

namespace votess::cpu {

struct SortedSeeds {
    std::vector<double> x, y, z;             // scaled coordinates, M seeds without duplicates, padded by group_size
    std::vector<std::int32_t> input;         // M: index in the input
    std::vector<std::int32_t> duplicate_of;  // N when there are duplicates, else empty; -1 for the others
    std::size_t duplicates = 0;

    [[nodiscard]] std::size_t size() const { return input.size(); }
};

inline constexpr std::size_t group_size = 8;  // consecutive seeds that share a candidate window

// points: 3N; each coordinate is multiplied by `scale`, a power of two. resolution: grid blocks along the longest
// axis, 0 = about two seeds a block.
SortedSeeds sort_seeds(std::span<const double> points, double scale, unsigned resolution, ThreadPool& pool);
SortedSeeds sort_seeds(std::span<const float> points, double scale, unsigned resolution, ThreadPool& pool);

}  // namespace votess::cpu

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "buffer.hpp"

namespace votess::cpu {

inline constexpr std::size_t group_size = 8;  // consecutive seeds that share a candidate window

struct SortedSeeds {
    Buffer<double> x, y, z;                  // scaled coordinates, M seeds without duplicates, padded by group_size
    Buffer<std::int32_t> input;              // M: index in the input
    std::vector<std::int32_t> duplicate_of;  // N when there are duplicates, else empty; -1 for the others
    std::size_t duplicates = 0;

    [[nodiscard]] std::size_t size() const { return input.size(); }
};

}  // namespace votess::cpu

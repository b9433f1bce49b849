#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "buffer.hpp"

namespace votess::cpu {

inline constexpr std::size_t group_size = 8;  // consecutive seeds that share a candidate window

struct SortedSeeds {
    // Scaled coordinates, M seeds without duplicates, padded by group_size. Read and written everywhere at once.
    static constexpr auto pages = Buffer<double>::Pages::huge;
    Buffer<double> x{pages}, y{pages}, z{pages};
    Buffer<std::int32_t> input;              // M: index in the input
    std::vector<std::int32_t> duplicate_of;  // N when there are duplicates, else empty; -1 for the others
    std::size_t duplicates = 0;

    [[nodiscard]] std::size_t size() const { return input.size(); }
};

}  // namespace votess::cpu

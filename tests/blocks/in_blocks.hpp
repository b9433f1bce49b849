// A run in blocks in one process, joined to a whole result.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "distributed/blocks/blocks.hpp"

namespace test {

struct InBlocks {
    votess::BlockCells cells;  // of all seeds, in input order
    votess::BlockCounts counts;
    std::uint64_t seeds = 0;
};
InBlocks in_blocks(std::span<const double> points, const votess::Options& options, std::size_t blocks);

// Returns "" when the cells are those of t, to the last digit, else the first difference.
std::string difference(const InBlocks& found, const votess::Tessellation& t);

}  // namespace test

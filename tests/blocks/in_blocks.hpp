// A run in blocks within one process, as a whole result to compare.
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

// "" when these are the cells of t: rows, shifts, statuses and counts exactly, geometry to the digits promised.
std::string difference(const InBlocks& found, const votess::Tessellation& t);

}  // namespace test

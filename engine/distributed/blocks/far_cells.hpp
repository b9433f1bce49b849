// Cells of a domain without end that reach beyond the near ends of its blocks. They are few. So all of them are found
// in one place, among themselves and their near neighbors, as run_endless() does in memory.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "distributed/blocks/local_block.hpp"

namespace votess::blocks {

struct FarCells {
    std::vector<std::int64_t> ids;  // of the cells
    Seeds seeds;                    // of the cells and their neighbors, some of them repeatedly

    [[nodiscard]] std::size_t size() const { return ids.size(); }
    static auto parts(auto& far) { return std::tie(far.ids, far.seeds); }
    // Adds the far ones of the first `count` cells of the run. Returns their rows, ascending. skipped: rows that do not
    // count, ascending. Throws `unsupported` for an empty cell, which all seeds together may have far out.
    std::vector<std::uint32_t> take(const BlockDomain& domain, const Run& run, std::size_t count,
                                    std::span<const std::uint32_t> skipped);
    void add(const FarCells& others) {
        ids.insert(ids.end(), others.ids.begin(), others.ids.end());
        seeds.add(others.seeds);
    }
};

// Finds far cells, ascending by id, among the seeds of all: the rows of the run.
void find_far(const BlockDomain& domain, const FarCells& all, std::span<const std::int64_t> ids, Run& run);

}  // namespace votess::blocks

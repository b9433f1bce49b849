// Cells that travel from the ranks that made them to the ranks that handed their seeds in.
#pragma once

#include <vector>

#include "core/bytes.hpp"
#include "input/settled.hpp"
#include "votess/block_cells.hpp"

namespace votess::mpi {

// The cells of one block, and the places of some of them.
struct SomeCells {
    std::vector<std::int64_t> ids;
    BlockCells cells;
    std::vector<std::size_t> places;
};
Message pack(const std::vector<std::int64_t>& ids, const BlockCells& cells, const std::vector<std::size_t>& places,
             bool planar);
// Joins the cells of all blocks in the order of ids. status: `outside` for seeds that were dropped, which have the
// values of seeds without a cell in all wanted arrays. whole: the run. own: the cells of the rank's own block
// that need no message.
BlockCells unpack(const std::vector<Message>& from, const std::vector<std::int64_t>& ids,
                  const std::vector<CellStatus>& status, const Settled& whole, SomeCells own);

}  // namespace votess::mpi

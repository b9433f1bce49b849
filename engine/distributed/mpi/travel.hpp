// Seeds on their way to blocks, and cells on their way back.
#pragma once

#include <vector>

#include "core/bytes.hpp"
#include "votess/block_cells.hpp"

namespace votess::mpi {

// The cells of a block at these places.
Message pack(const std::vector<std::int64_t>& ids, const BlockCells& cells, const std::vector<std::size_t>& places);
// The cells of the rank's own block, at the places of those that it handed in itself: they need no message.
struct OwnCells {
    std::vector<std::int64_t> ids;
    BlockCells cells;
    std::vector<std::size_t> places;
};
// Those of all blocks, in the order of ids. status: of seeds that were left out, `outside`.
BlockCells unpack(const std::vector<Message>& from, const std::vector<std::int64_t>& ids,
                  const std::vector<CellStatus>& status, OwnCells own);

}  // namespace votess::mpi

// The cells of one rank; see votess/mpi.hpp.
#pragma once

#include <cstdint>
#include <vector>

#include "votess/row_arrays.hpp"

namespace votess {

// N cells. The rows are always present.
struct BlockCells : RowArrays<detail::Vector> {
    std::vector<std::int32_t> owners;  // entries: tags of the neighbors, -1 for walls
};

}  // namespace votess

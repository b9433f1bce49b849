// Writes the result of all ranks into one HDF5 file, with the arrays and attributes of clvotess.
#pragma once

#include <vector>
#include <votess/mpi.hpp>

#include "mpi/ranks.hpp"
#include "mpi/read_share.hpp"
#include "write/output.hpp"

namespace clvotess {

// Collective. Writes to each path. data: its tessellation has no seeds, and states the domain.
void write_ranks(const Ranks& ranks, const std::vector<std::string>& paths, const InputShare& share,
                 const votess::BlockCells& cells, const OutputData& data);

}  // namespace clvotess

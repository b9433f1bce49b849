// The result of all ranks in one HDF5 file, with the arrays and attributes that clvotess writes.
#pragma once

#include <vector>
#include <votess/mpi.hpp>

#include "mpi/ranks.hpp"
#include "mpi/read_share.hpp"
#include "write/output.hpp"

namespace clvotess {

// Collective, to each path. data: with a tessellation of no seeds for the domain.
void write_ranks(const Ranks& ranks, const std::vector<std::string>& paths, const InputShare& share,
                 const votess::BlockCells& cells, const OutputData& data);

}  // namespace clvotess

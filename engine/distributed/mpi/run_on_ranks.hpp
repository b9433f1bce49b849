// A run over the ranks of a communicator.
#pragma once

#include <functional>

#include "input/settled.hpp"
#include "votess/mpi.hpp"

namespace votess::mpi {

// settle: makes the same run on all ranks, without seeds. It may throw on some of them.
[[nodiscard]] Result run_on_ranks(MPI_Comm comm, std::span<const double> points, std::span<const std::int64_t> ids,
                                  const std::function<Settled()>& settle, Cells cells);
// given: no other domain.
[[nodiscard]] std::vector<Wall> hull_of_ranks(MPI_Comm comm, std::span<const double> points, const Region& given);

}  // namespace votess::mpi

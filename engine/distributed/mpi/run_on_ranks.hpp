// A run over the ranks of a communicator.
#pragma once

#include <functional>

#include "distributed/mpi/exchange.hpp"
#include "input/settled.hpp"
#include "votess/mpi.hpp"

namespace votess::mpi {

// common: the arguments that must be the same on all ranks. settle: makes the run, without seeds. It may throw on some
// ranks.
[[nodiscard]] Result run_on_ranks(MPI_Comm comm, std::span<const double> points, std::span<const std::int64_t> ids,
                                  std::span<const CommonArgument> common, const std::function<Settled()>& settle,
                                  Cells cells);
// given: no other domain.
[[nodiscard]] std::vector<Wall> hull_of_ranks(MPI_Comm comm, std::span<const double> points, const Region& given);

}  // namespace votess::mpi

// The public functions of votess_mpi that take options.
#include "distributed/mpi/run_on_ranks.hpp"
#include "input/settle.hpp"

namespace votess::mpi {

std::vector<Wall> hull_walls(MPI_Comm comm, std::span<const double> points, const Options& options) {
    return hull_of_ranks(comm, points, region_of(options));
}

Result tessellate(MPI_Comm comm, std::span<const double> points, std::span<const std::int64_t> ids,
                  const Options& options, Cells cells) {
    return run_on_ranks(
        comm, points, ids, [&] { return settle(options); }, cells);
}

}  // namespace votess::mpi

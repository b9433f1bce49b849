// The public functions of votess_mpi that take options.
#include <vector>

#include "core/arithmetic.hpp"
#include "distributed/mpi/run_on_ranks.hpp"
#include "input/settle.hpp"

namespace votess::mpi {
namespace {

// Returns the arguments that must be the same on all ranks.
std::vector<CommonArgument> common_arguments(const Options& options, Cells where) {
    Hash box, cell, walls;
    if (options.box) box.mix(*options.box);
    if (const auto& edges = options.cell) cell.mix(edges->origin, edges->a, edges->b, edges->c, edges->periodic);
    for (const Wall& wall : options.walls) walls.mix(wall);
    const auto of = [](const auto& value) { return Hash().mix(value).value(); };
    return {{"cells", of(where)},
            {"box", box.value()},
            {"cell", cell.value()},
            {"periodic", of(options.periodic)},
            {"walls", walls.value()},
            {"outside", of(options.outside)},
            {"duplicates", of(options.duplicates)},
            {"want", of(options.want)},
            {"list_walls", of(options.list_walls)},
            {"min_face", of(options.min_face)},
            {"min_area", of(options.min_area)},
            {"the number of dimensions", of(options.planar)}};
}

}  // namespace

std::vector<Wall> hull_walls(MPI_Comm comm, std::span<const double> points, const Options& options) {
    return hull_of_ranks(comm, points, region_of(options));
}

Result tessellate(MPI_Comm comm, std::span<const double> points, std::span<const std::int64_t> ids,
                  const Options& options, Cells cells) {
    return run_on_ranks(
        comm, points, ids, common_arguments(options, cells), [&] { return settle(options); }, cells);
}

}  // namespace votess::mpi

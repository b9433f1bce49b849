#include "mpi/help.hpp"

#include <algorithm>
#include <string_view>
#include <votess/version.hpp>

#include "failure.hpp"

namespace clvotess {
namespace {

constexpr std::string_view text =
    R"(clvotess-mpi: exact 3D Voronoi tessellation over the ranks of MPI

usage: mpirun -np P clvotess-mpi INPUT [options] -o OUT.h5
       mpirun -np P clvotess-mpi --random N [--rng-seed S] [options] -o OUT.h5

Each rank reads its share of the rows, finds cells on the CPU, and writes its rows of the one
output file, which holds what clvotess writes: the lists do not depend on the number of ranks.

The options are those of clvotess (clvotess --help), with these differences:
  INPUT                .npy, .h5 and snapshots: each rank reads its rows; others, also stdin,
                       are read by rank 0, which deals them out
  -o, --output FILE    .h5 or .hdf5, once; in a folder that all machines share
  -t, --threads N      CPU threads of each rank; default 1; 0 = all of its machine
  --json               also ranks, rounds, ghosts_received, ghosts_needed; seconds.clip is all
                       of the tessellation, peak_memory_bytes that of the largest rank

Refused, since no rank has all seeds or cells: --want vertices,faces, --min-face, --min-area,
--image, .vtu .ply .obj .glb, --locate, --probe, --interpolate, --to-grid; other devices than
the CPU; other files than HDF5.

exit codes: those of clvotess, on all ranks alike
)";

}  // namespace

std::string answer_of_ranks(int count, const char* const* values) {
    const auto given = [&](std::string_view option) {
        return std::any_of(values + 1, values + count, [&](const char* word) { return word == option; });
    };
    if (given("-h") || given("--help") || given("--help-all")) return std::string(text);
    if (given("--version")) return "clvotess-mpi " VOTESS_VERSION_STRING "\n";
    throw bad_input("--man, --completion and --list-devices are those of clvotess: run clvotess");
}

}  // namespace clvotess

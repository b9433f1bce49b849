#include "mpi/options.hpp"

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

bool is_hdf5_output(const std::string& path) {
    const std::string extension = path == "-" ? "" : extension_of(path);
    return extension == ".h5" || extension == ".hdf5";
}

}  // namespace

std::string answer_of_ranks(int count, const char* const* values) {
    const auto given = [&](std::string_view option) {
        return std::any_of(values + 1, values + count, [&](const char* word) { return word == option; });
    };
    if (given("-h") || given("--help") || given("--help-all")) return std::string(text);
    if (given("--version")) return "clvotess-mpi " VOTESS_VERSION_STRING "\n";
    throw bad_input("--man, --completion and --list-devices work with clvotess only: run clvotess");
}

void refuse_for_ranks(const Arguments& arguments) {
    const auto refuse = [](const std::string& what) { throw bad_input(what + ", or run clvotess"); };
    const votess::Options& options = arguments.options;
    if (!arguments.locate.empty() || !arguments.probe.empty() || !arguments.interpolate.empty() || arguments.to_grid)
        refuse("--locate, --probe, --interpolate and --to-grid need all seeds in one memory: leave them out");
    if (arguments.memory > 0 || !arguments.temporary.empty())
        refuse("--memory and --temporary are for one machine: leave them out and take more ranks");
    if (arguments.picture) refuse("--image needs all cells in one memory: leave it out");
    for (const std::string& path : arguments.outputs)
        if (!is_hdf5_output(path))
            refuse("cannot write " + in_quotes(path) + ": ranks write one HDF5 file together: name it .h5");
    if (arguments.outputs.size() > 1) refuse("ranks write one HDF5 file together: give -o once");
    if (options.device != "auto" && options.device != "cpu")
        refuse("--device " + options.device + ": ranks find their cells on the CPU: leave it out");
    if (arguments.wanted.vertices || arguments.wanted.faces)
        refuse("--want vertices and faces are numbered over all cells, which no rank has: leave them out");
    if (options.min_face != 0 || options.min_area != 0)
        refuse("--min-face and --min-area need the faces of all cells: leave them out");
}

}  // namespace clvotess

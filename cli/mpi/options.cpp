#include "mpi/options.hpp"

#include <algorithm>
#include <string_view>
#include <votess/version.hpp>

#include "failure.hpp"

namespace clvotess {
namespace {

constexpr std::string_view text =
    R"(clvotess-mpi: exact Voronoi tessellation over the ranks of MPI

usage: mpirun -np P clvotess-mpi INPUT [options] -o OUT.h5
       mpirun -np P clvotess-mpi --random N [--rng-seed S] [options] -o OUT.h5

Each rank reads its share of the rows, finds cells on the CPU, and writes its rows of the one
output file, which holds what clvotess writes: the lists do not depend on the number of ranks.

The options are those of clvotess (clvotess --help), with these differences:
  INPUT                .npy, .h5 and snapshots: each rank reads its rows; rank 0 reads other
                       files and stdin, and deals the rows out
  -o, --output FILE    .h5 or .hdf5, once; in a folder that all machines share
  -x, --device         cpu only
  -t, --threads N      CPU threads of each rank; default 1; 0 = all of its machine
  --want LIST          not vertices and faces
  --json               also ranks, rounds, ghosts_received, ghosts_needed; seconds.clip is the
                       whole tessellation, peak_memory_bytes that of the largest rank

Refused, because no rank has all points and cells:
 )";

std::string help() {
    std::string page(text);
    std::size_t length = 1;
    each_option([&](const Option& option) {
        if (option.traits.needs <= Needs::cells) return;
        const std::string name = long_name(option);
        if (length + 1 + name.size() > 95) page += "\n ", length = 1;
        page += ' ' + name;
        length += 1 + name.size();
    });
    return page + "\n\nexit codes: those of clvotess, on all ranks alike\n";
}

}  // namespace

std::string answer_of_ranks(int count, const char* const* values) {
    const auto given = [&](std::string_view option) {
        return std::any_of(values + 1, values + count, [&](const char* word) { return word == option; });
    };
    if (given("-h") || given("--help") || given("--help-all")) return help();
    if (given("--version")) return "clvotess-mpi " VOTESS_VERSION_STRING "\n";
    throw bad_input("--man, --completion and --list-devices work with clvotess only: run clvotess");
}

void refuse_for_ranks(const Arguments& arguments) {
    const auto refuse = [](const std::string& what) { throw bad_input(what + ", or run clvotess"); };
    const votess::Options& options = arguments.options;
    if (const Option* option = arguments.find_needing({Needs::all_cells, Needs::all_points, Needs::one_machine}))
        refuse(long_name(*option) + " needs all points and cells on one machine: leave it out");
    if (arguments.covalent) refuse("--radii covalent: ranks read columns of numbers: name a column of radii");
    for (const std::string& path : arguments.outputs)
        if (!names_hdf5(path))
            refuse("cannot write " + in_quotes(path) + ": ranks write one HDF5 file together: name it .h5");
    if (arguments.outputs.size() > 1) refuse("ranks write one HDF5 file together: give -o once");
    if (options.device != "auto" && options.device != "cpu")
        refuse("--device " + options.device + ": ranks find their cells on the CPU: leave it out");
    if (arguments.wanted.vertices || arguments.wanted.faces)
        refuse("--want vertices and faces are numbered over all cells, which no rank has: leave them out");
}

}  // namespace clvotess

#include "mpi/refusals.hpp"

#include <string>

#include "failure.hpp"

namespace clvotess {
namespace {

bool is_hdf5_output(const std::string& path) {
    const std::string extension = path == "-" ? "" : extension_of(path);
    return extension == ".h5" || extension == ".hdf5";
}

}  // namespace

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

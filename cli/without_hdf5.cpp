// For builds without the HDF5 library.
#include "failure.hpp"
#include "input.hpp"
#include "output.hpp"

namespace clvotess {
namespace {

constexpr const char* missing = ": this build of clvotess has no HDF5 (build it where libhdf5-dev is installed)";

}  // namespace

bool has_hdf5() {
    return false;
}

Input read_hdf5(const std::string& path, const ReadRequest&) {
    throw bad_input("cannot read " + in_quotes(path) + missing);
}

void write_hdf5(OutputFile&, const OutputData&) {
    throw bad_input(std::string("cannot write .h5") + missing);
}

}  // namespace clvotess

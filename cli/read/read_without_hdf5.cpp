// For builds without the HDF5 library.
#include "failure.hpp"
#include "read/input.hpp"

namespace clvotess {

Input read_hdf5(const std::string& path, const ReadRequest&) {
    throw bad_input("cannot read " + in_quotes(path) +
                    ": this build of clvotess has no HDF5 (build it where libhdf5-dev is installed)");
}

}  // namespace clvotess

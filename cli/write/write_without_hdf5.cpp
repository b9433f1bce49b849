// For builds without the HDF5 library. check_outputs() refuses .h5 before any work.
#include "failure.hpp"
#include "write/output.hpp"

namespace clvotess {

bool has_hdf5() {
    return false;
}

void write_hdf5(OutputFile&, const OutputData&) {
    throw bad_input("this build of clvotess has no HDF5 (build it where libhdf5-dev is installed)");
}

}  // namespace clvotess

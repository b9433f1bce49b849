// clvotess-mpi links the parallel HDF5, so it loads no module.
#include "files/formats/hdf5_module.hpp"

extern "C" const clvotess::Hdf5Module clvotess_hdf5;

namespace clvotess {

const Hdf5Module& load_hdf5(const std::string&) {
    return clvotess_hdf5;
}

}  // namespace clvotess

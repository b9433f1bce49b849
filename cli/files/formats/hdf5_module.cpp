#include "files/formats/hdf5_module.hpp"

#include <dlfcn.h>

#include "failure.hpp"

namespace clvotess {

const Hdf5Module& load_hdf5(const std::string& task) {
    void* const library = dlopen(CLVOTESS_HDF5_MODULE, RTLD_NOW | RTLD_LOCAL);
    const void* const module = library ? dlsym(library, "clvotess_hdf5") : nullptr;
    if (!module) {
        throw bad_input(task + ": the module for HDF5 cannot be loaded: " + dlerror() +
                        " (build clvotess where libhdf5-dev is installed, and keep lib/votess beside the folder of "
                        "clvotess, $ORIGIN)");
    }
    return *static_cast<const Hdf5Module*>(module);
}

}  // namespace clvotess

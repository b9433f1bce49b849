#include "files/formats/hdf5_module.hpp"

#include <dlfcn.h>

#include <filesystem>

#include "failure.hpp"

namespace clvotess {
namespace {

// Returns the path of the module, beside the program. $ORIGIN does not work: with a sanitizer it is another folder.
std::string module_path() {
    const auto program = std::filesystem::read_symlink("/proc/self/exe");
    return (program.parent_path() / CLVOTESS_HDF5_MODULE).lexically_normal().string();
}

}  // namespace

const Hdf5Module& load_hdf5(const std::string& task) {
    void* const library = dlopen(module_path().c_str(), RTLD_NOW | RTLD_LOCAL);
    const void* const module = library ? dlsym(library, "clvotess_hdf5") : nullptr;
    if (!module) {
        throw bad_input(task + ": the module for HDF5 cannot be loaded: " + dlerror() +
                        " (build clvotess where libhdf5-dev is installed, and keep lib/votess beside the folder of "
                        "clvotess)");
    }
    return *static_cast<const Hdf5Module*>(module);
}

}  // namespace clvotess

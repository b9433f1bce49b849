#include "files/formats/hdf5_module.hpp"

#include "core/system.hpp"
#include "failure.hpp"

namespace clvotess {
namespace {

// Returns the path of the module, beside the program. $ORIGIN does not work: with a sanitizer it is another folder.
std::filesystem::path module_path() {
    return (votess::system::program_path().parent_path() / CLVOTESS_HDF5_MODULE).lexically_normal();
}

}  // namespace

const Hdf5Module& load_hdf5(const std::string& task) {
    const std::filesystem::path path = module_path();
    std::string failure = path.string() + ": it is of another build than clvotess: install both from one build";
    const auto library = votess::system::SharedLibrary::open(path, failure);
    const void* const module = library.is_open() ? library.symbol(CLVOTESS_HDF5_NAME) : nullptr;
    if (!module) {
        throw bad_input(task + ": the module for HDF5 cannot be loaded: " + failure +
                        " (build clvotess where libhdf5-dev is installed, and keep lib/votess beside the folder of "
                        "clvotess)");
    }
    return *static_cast<const Hdf5Module*>(module);
}

}  // namespace clvotess

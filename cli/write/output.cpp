#include "write/output.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "failure.hpp"
#include "files/formats/hdf5_module.hpp"
#include "files/output_file.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

struct Kind {
    std::string_view extension;
    void (*write)(OutputFile&, const OutputData&);
    bool mesh;     // holds polygons of faces
    bool carries;  // holds columns of the input
};

void write_hdf5(OutputFile& file, const OutputData& data) {
    load_hdf5("cannot write HDF5").write(file, data);
}

constexpr std::array<Kind, 9> kinds{{{".txt", write_text, false, true},
                                     {".vol", write_text, false, true},
                                     {".npz", write_npz, false, true},
                                     {".h5", write_hdf5, false, true},
                                     {".hdf5", write_hdf5, false, true},
                                     {".vtu", write_vtu, true, true},
                                     {".ply", write_ply, true, false},
                                     {".obj", write_obj, true, false},
                                     {".glb", write_glb, true, false}}};

// Returns the kind of an output, or null. Text is the kind of stdout, and of a device or pipe without a known
// extension.
const Kind* kind_of(const std::string& path) {
    const std::string extension = extension_of(path);
    const auto* const kind = std::ranges::find(kinds, std::string_view(extension), &Kind::extension);
    if (path != "-" && kind != kinds.end()) return kind;
    return path == "-" || is_special_file(path) ? kinds.data() : nullptr;
}

}  // namespace

bool is_text_output(const std::string& path) {
    const Kind* const kind = kind_of(path);
    return kind && kind->write == write_text;
}

bool carries_columns(const std::string& path) {
    const Kind* const kind = kind_of(path);
    return kind && kind->carries;
}

bool is_colored(const std::string& path) {
    const Kind* const kind = kind_of(path);
    return kind && kind->write == write_glb;
}

// The name of a dataset of HDF5 is the last part of its path.
std::vector<InputColumn> carried_columns(const std::vector<std::string>& outputs, std::vector<InputColumn> columns) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
        std::string& name = columns[c].name;
        name = name.substr(name.rfind('/') + 1);
        const auto twice = std::ranges::find(columns.begin(), columns.begin() + static_cast<std::ptrdiff_t>(c), name,
                                             &InputColumn::name);
        if (twice != columns.begin() + static_cast<std::ptrdiff_t>(c)) {
            throw bad_input("the column " + in_quotes(name) + " is requested twice: name it once");
        }
        for (const std::string& path : outputs) {
            const Kind* const kind = kind_of(path);
            const bool taken =
                kind->write == write_vtu ? is_vtu_array(name) : kind->write != write_text && is_result_array(name);
            if (kind->carries && taken) {
                throw bad_input("cannot carry the column " + in_quotes(name) + " into " + in_quotes(path) +
                                ", which has an array of that name: rename the column");
            }
        }
    }
    return columns;
}

void add_output_needs(const std::string& path, votess::Want& want) {
    const Kind* const kind = kind_of(path);
    if (!kind || !kind->mesh) return;
    want.faces = true;
    if (kind->write == write_vtu) want.volumes = want.centroids = true;
}

void check_paths(const std::vector<std::string>& paths, const std::vector<std::string>& inputs) {
    std::set<std::string> seen, read;
    for (const std::string& input : inputs)
        if (!input.empty() && input != "-" && !is_special_file(input)) read.insert(identity_of(input));
    for (const std::string& path : paths) {
        if (path != "-") check_writable(path);
        const std::string identity = identity_of(path);
        if (!seen.insert(identity).second)
            throw bad_input("output " + in_quotes(path) + " is named twice: name it once");
        if (path != "-" && read.contains(identity))
            throw bad_input("output " + in_quotes(path) + " is the input: give it another name");
    }
}

void check_hdf5(const std::string& path) {
    load_hdf5("cannot write " + in_quotes(path));
    if (is_special_file(path))
        throw bad_input("cannot write " + in_quotes(path) +
                        ": HDF5 needs a regular file, not a device or a pipe: give the name of a file");
}

void check_outputs(const std::vector<std::string>& paths, const std::vector<std::string>& inputs) {
    for (const std::string& path : paths) {
        const Kind* const kind = kind_of(path);
        if (!kind) {
            throw bad_input("cannot write " + in_quotes(path) +
                            ": known are .txt .npz .h5 .hdf5 .vtu .ply .obj .glb, and text on stdout as -");
        }
        if (kind->write == write_hdf5) check_hdf5(path);
    }
    check_paths(paths, inputs);
}

std::vector<Attribute> attributes_of(std::vector<Attribute> units, const DomainFrom& domain_from) {
    units.push_back({"domain_from", word_of(domain_from.box)});
    units.push_back({"periodic_from", word_of(domain_from.periodic)});
    units.push_back({"version", VOTESS_VERSION_STRING});
    return units;
}

void write_outputs(const std::vector<std::string>& paths, const OutputData& data) {
    std::vector<OutputFile> files;
    files.reserve(paths.size());
    for (const std::string& path : paths) {
        OutputFile& file = files.emplace_back(path);
        kind_of(path)->write(file, data);
        file.finish();
    }
    for (OutputFile& file : files) file.publish();
}

}  // namespace clvotess

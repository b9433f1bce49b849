#include "write/output.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "failure.hpp"
#include "files/formats/hdf5_module.hpp"
#include "files/output_file.hpp"
#include "interrupt.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

struct Kind {
    std::string_view extension;
    void (*write)(OutputFile&, const OutputData&);  // null: write_solid()
    unsigned traits;
};

void write_hdf5(OutputFile& file, const OutputData& data) {
    load_hdf5("cannot write HDF5").write(file, data);
}

constexpr unsigned rows = input_columns | many_frames, atoms = table | rows | species_column | in_box,
                   mesh = polyhedra | in_box, solid = mesh | in_space, solver = solid | shared_faces,
                   of_pieces = cell_pieces | in_space;
constexpr std::array<Kind, 21> kinds{{{".txt", write_text, text_rows | rows},
                                      {".vol", write_text, text_rows | rows},
                                      {".npz", write_npz, any_arrays | input_columns},
                                      {".h5", write_hdf5, any_arrays | rows},
                                      {".hdf5", write_hdf5, any_arrays | rows},
                                      {".csv", write_csv, table | rows},
                                      {".xyz", write_xyz, atoms},
                                      {".extxyz", write_xyz, atoms},
                                      {".dump", write_dump, atoms},
                                      {".lammpstrj", write_dump, atoms},
                                      {".vtu", write_vtu, mesh | cell_pieces | input_columns},
                                      {".ply", nullptr, solid},
                                      {".obj", nullptr, solid | of_pieces},
                                      {".glb", write_glb, solid | of_pieces | cell_colors},
                                      {".foam", write_foam, solver | of_pieces | joined_pieces},
                                      {".tess", write_tess, solver},
                                      {".msh", nullptr, solver | of_pieces | joined_pieces},
                                      {".cgns", nullptr, solver | of_pieces | joined_pieces},
                                      {".stl", nullptr, solver | of_pieces},
                                      {".3mf", nullptr, of_pieces},
                                      {".geojson", nullptr, cell_pieces}}};

// Returns the kind of an output, or null. Text is the kind of stdout, and of a device or pipe without a known
// extension.
const Kind* kind_of(const std::string& path) {
    const std::string extension = extension_of(path);
    const auto* const kind = std::ranges::find(kinds, std::string_view(extension), &Kind::extension);
    if (path != "-" && kind != kinds.end()) return kind;
    return path == "-" || is_special_file(path) ? kinds.data() : nullptr;
}

bool is_foam(const std::string& path) {
    const Kind* const kind = kind_of(path);
    return kind && kind->write == write_foam;
}

// Returns the folder of a mesh of OpenFOAM.
std::string mesh_folder_of(const std::string& path) {
    return path.substr(0, path.find_last_of("/\\") + 1) + "constant/polyMesh";
}

}  // namespace

bool output_has(const std::string& path, unsigned traits) {
    const Kind* const kind = kind_of(path);
    return kind && (kind->traits & traits) != 0;
}

bool any_output_has(const std::vector<std::string>& paths, unsigned traits) {
    return std::ranges::any_of(paths, [traits](const std::string& path) { return output_has(path, traits); });
}

// Throws Failure for a name or words that a file with blanks between its columns cannot hold.
void check_blanks(const std::string& path, const std::string& name, const std::vector<std::string>& words) {
    const Kind& kind = *kind_of(path);
    if (kind.write == write_csv || (kind.traits & (text_rows | table)) == 0) return;
    const auto check = [&](const std::string& text, const char* what, const char* marks) {
        if (text.empty() || text.find_first_of(marks) != std::string::npos)
            throw bad_input("cannot carry the column " + in_quotes(name) + " into " + in_quotes(path) + ", for its " +
                            what + in_quotes(text) + " would not be one word there: write .csv, .npz or .h5");
    };
    if (kind.write != write_text) check(name, "name ", kind.write == write_xyz ? " \t\r\n\":=" : " \t\r\n");
    for (const std::string& word : words) check(word, "text ", " \t\r\n");
}

void check_name(const InputColumn& column) {
    if (!is_utf8(column.name))
        throw bad_input("the column " + in_quotes(column.name) +
                        " has a name that is not UTF-8: convert the file, as iconv -f latin1 -t utf-8 does");
}

// The name of a dataset of HDF5 is the last part of its path.
std::vector<InputColumn> carried_columns(const std::vector<std::string>& outputs, std::vector<InputColumn> columns,
                                         bool planar) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
        std::string& name = columns[c].name;
        name = name.substr(name.rfind('/') + 1);
        const auto twice = std::ranges::find(columns.begin(), columns.begin() + static_cast<std::ptrdiff_t>(c), name,
                                             &InputColumn::name);
        if (twice != columns.begin() + static_cast<std::ptrdiff_t>(c)) {
            throw bad_input("the column " + in_quotes(name) + " is requested twice: name it once");
        }
        for (const std::string& path : outputs) {
            const bool carries = output_has(path, input_columns), is_text = output_has(path, text_rows);
            const bool is_vtu = kind_of(path)->write == write_vtu;
            if (columns[c].of_words && is_vtu)
                throw bad_input("cannot carry the words of " + in_quotes(name) + " into " + in_quotes(path) +
                                ", which holds numbers: write .csv, .xyz, .dump, .npz or .h5");
            const bool taken = is_vtu                    ? is_vtu_array(name)
                               : output_has(path, table) ? is_table_column(name, planar)
                                                         : !is_text && is_result_array(name);
            if (carries && !is_text) check_name(columns[c]);
            check_blanks(path, name, columns[c].words);
            if (carries && taken) {
                throw bad_input("cannot carry the column " + in_quotes(name) + " into " + in_quotes(path) +
                                ", which has an array of that name: rename the column");
            }
        }
    }
    return columns;
}

void add_output_needs(const std::string& path, bool want_given, votess::Want& want, bool in_mesh) {
    const Kind* const kind = kind_of(path);
    const bool is_vtu = kind && kind->write == write_vtu;
    if (output_has(path, table) && !want_given) {
        want.neighbors = want.volumes = true;
        want.faces = !in_mesh;
    }
    if (in_mesh && is_vtu) want.neighbors = true;
    if (!output_has(path, polyhedra) || in_mesh) return;
    want.faces = true;
    if (is_vtu) want.volumes = want.centroids = true;
}

void check_paths(const std::vector<std::string>& paths, const std::vector<std::string>& inputs) {
    std::set<std::string> seen, read;
    for (const std::string& input : inputs)
        if (!input.empty() && input != "-" && !is_special_file(input)) read.insert(identity_of(input));
    for (const std::string& path : paths) {
        if (path != "-") check_writable(path);
        const std::string identity = identity_of(is_foam(path) ? mesh_folder_of(path) : path);
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
                            ": known are .txt .csv .xyz .dump .npz .h5 .hdf5 .vtu .ply .obj .glb .stl .foam .tess "
                            ".msh .cgns, with --mesh .3mf and .geojson, and text on stdout as -");
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

bool names_frame(const std::string& path) {
    return path.find(frame_mark) != std::string::npos;
}

std::string with_frame(std::string path, std::uint64_t number) {
    for (std::size_t at = 0; (at = path.find(frame_mark)) != std::string::npos;)
        path.replace(at, frame_mark.size(), std::to_string(number));
    return path;
}

void check_frame_names(const std::vector<std::string>& paths, bool several) {
    for (const std::string& path : paths) {
        if (!several && names_frame(path))
            throw bad_input("output " + in_quotes(path) + " is named by frames: add --frames all");
        if (several && is_foam(path))
            throw bad_input("cannot write all frames into " + in_quotes(path) +
                            ", whose folder holds one mesh: choose a frame by --frame N");
        if (several && !names_frame(path) && !output_has(path, many_frames))
            throw bad_input("cannot write all frames into " + in_quotes(path) +
                            ", which holds one: let {frame} stand for its number in the name, as in out-{frame}" +
                            extension_of(path));
    }
}

std::string frame_line(const Input& frame, std::size_t rows, const char* of) {
    const std::string step = frame.timestep.empty() ? "" : ", timestep " + frame.timestep;
    return "# frame " + std::to_string(frame.frame.value_or(0)) + step + ", " + std::to_string(rows) + " " + of + "\n";
}

// Text, or a file of one of the formats that hold several frames.
struct Outputs::Shared {
    explicit Shared(const std::string& path) : file(path) {}
    OutputFile file;
    std::unique_ptr<FramesFile> writer;  // of .h5
    bool begun = false;
};

Outputs::Outputs(bool several) : several_(several) {}
Outputs::~Outputs() = default;

FramePlace Outputs::place(const std::string& path) const {
    if (!several_ || names_frame(path)) return FramePlace::alone;
    const auto found = shared_.find(path);
    return found != shared_.end() && found->second->begun ? FramePlace::later : FramePlace::first;
}

Outputs::Shared& Outputs::shared(const std::string& path) {
    std::unique_ptr<Shared>& shared = shared_[path];
    if (!shared) shared = std::make_unique<Shared>(path);
    return *shared;
}

void Outputs::add(const std::string& path, const std::function<void(OutputFile&)>& write) {
    if (place(path) == FramePlace::alone) {
        write(complete_.emplace_back(several_ ? with_frame(path, number_) : path));
        complete_.back().finish();
    } else {
        Shared& file = shared(path);
        write(file.file);
        file.begun = true;
    }
}

void Outputs::add(const std::string& path, const OutputData& data) {
    const Kind& kind = *kind_of(path);
    if (output_has(path, species_column)) check_blanks(path, "species", data.input.species);
    if (kind.write != write_hdf5 || data.place == FramePlace::alone)
        return add(path, [&](OutputFile& file) {
            if (kind.write != nullptr)
                kind.write(file, data);
            else
                write_solid(file, data, kind.extension.data());
        });
    Shared& file = shared(path);
    if (!file.writer) file.writer = load_hdf5("cannot write HDF5").create_frames(file.file);
    file.writer->add(data);
    file.begun = true;
}

void Outputs::end_frame() {
    if (several_) publish_complete();
}

void Outputs::publish() {
    for (const auto& [_, shared] : shared_) {
        if (shared->writer) shared->writer->finish();
        shared->file.finish();
    }
    publish_complete();
    for (const auto& [_, shared] : shared_) shared->file.publish();
}

void Outputs::publish_complete() {
    throw_if_interrupted();
    for (OutputFile& file : complete_) file.publish();
    complete_.clear();
}

}  // namespace clvotess

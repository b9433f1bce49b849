// The outputs of -o. All files are complete before the first gets its name.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>
#include <votess/alpha.hpp>
#include <votess/votess.hpp>

#include "coloring.hpp"
#include "domain.hpp"
#include "files/output_file.hpp"
#include "read/input.hpp"
#include "write/text_format.hpp"

namespace clvotess {

// Throws Failure when a folder is missing or not writable, or when a path occurs twice or is an input. Inputs may be
// empty or "-".
void check_paths(const std::vector<std::string>& paths, const std::vector<std::string>& inputs);

// Throws Failure when the module of HDF5 is missing, or when the path is a device or pipe.
void check_hdf5(const std::string& path);

// Checks extensions, then as check_hdf5() and check_paths(). Throws Failure.
void check_outputs(const std::vector<std::string>& paths, const std::vector<std::string>& inputs);

// What a file of some extension holds, in bits.
enum OutputTrait : unsigned {
    text_rows = 1,       // by --format; also stdout
    table = 2,           // columns of the cells; those without --want have the default ones
    any_arrays = 4,      // of any length
    polyhedra = 8,       // cells as polygons
    cell_pieces = 16,    // of cells in a mesh. Without a mesh some such formats hold polyhedra, others nothing
    input_columns = 32,  // columns of the input
    many_frames = 64,
    cell_colors = 128,
    shared_faces = 256,  // --min-edge changes it
    species_column = 512,
    in_space = 1024,       // cannot hold cells of the plane
    in_box = 2048,         // needs a domain with ends
    joined_pieces = 4096,  // of cells in a mesh, with shared faces
};
// Returns whether a file of the path's extension has one of these traits.
[[nodiscard]] bool output_has(const std::string& path, unsigned traits);
[[nodiscard]] bool any_output_has(const std::vector<std::string>& paths, unsigned traits);

// Adds to `want` the arrays that a file of this extension needs. The needs of text depend on its format. Tables choose
// their columns unless --want does, which want_given states; in a mesh without polygons.
void add_output_needs(const std::string& path, bool want_given, votess::Want& want, bool in_mesh = false);

// Place of a result among those of its file.
enum class FramePlace { alone, first, later };

struct OutputData {
    const Input& input;
    const votess::Tessellation& tessellation;
    const votess::Want& wanted;  // arrays for .npz and .h5; the tessellation may hold more
    const TextFormat& format;
    std::span<const double> radii;  // for %r; may be empty
    const DomainFrom& domain_from;
    const std::vector<InputColumn>& carried;      // columns of the input, after the arrays of the cells
    const Coloring& coloring;                     // for .glb
    bool reports_size = false;                    // print the size of a .glb on stderr before it is written
    unsigned threads = 1;                         // that make text; 0: one per processor
    FramePlace place = FramePlace::alone;         // among the frames of the output
    bool has_radii = false;                       // --radii is given, also where there are no points
    std::span<const std::int64_t> all_ids = {};   // of all points, where the input has those of a subset; may be empty
    double gap = 0;                               // between pieces
    double min_edge = 0;                          // collapse shorter ones in meshes for solvers
    const votess::AlphaComplex* alpha = nullptr;  // for .npz and .h5; may be null
    bool skip_open = false;                       // leave cells that reach infinity out of meshes
};

// An output of several frames.
class FramesFile {
public:
    virtual ~FramesFile() = default;
    virtual void add(const OutputData& data) = 0;
    virtual void finish() = 0;
};

// The text in names of outputs that the number of the frame replaces.
inline constexpr std::string_view frame_mark = "{frame}";
[[nodiscard]] bool names_frame(const std::string& path);
[[nodiscard]] std::string with_frame(std::string path, std::uint64_t number);

// Returns the line before the rows of a frame, in text of several. of: what the rows are, such as "points".
[[nodiscard]] std::string frame_line(const Input& frame, std::size_t rows, const char* of);

// The files of a run. Those that hold all of its frames are complete before the first gets its name; those of one
// frame, whose names have the frame's number, get them after each frame.
class Outputs {
public:
    explicit Outputs(bool several);  // several: with --frames
    Outputs(const Outputs&) = delete;
    Outputs& operator=(const Outputs&) = delete;
    ~Outputs();

    void begin_frame(std::uint64_t number) { number_ = number; }
    // Add to the output of this name. Throw Failure.
    void add(const std::string& path, const OutputData& data);
    void add(const std::string& path, const std::function<void(OutputFile&)>& write);
    [[nodiscard]] FramePlace place(const std::string& path) const;  // of the frame
    void end_frame();
    void publish();

private:
    struct Shared;  // by all frames
    Shared& shared(const std::string& path);
    void publish_complete();

    bool several_;
    std::uint64_t number_ = 0;
    std::deque<OutputFile> complete_;
    std::map<std::string, std::unique_ptr<Shared>> shared_;
};

// Throws Failure for a format that holds one frame only, unless its name has the frame's number, and for names that
// have it without --frames.
void check_frame_names(const std::vector<std::string>& paths, bool several);

// Returns the attributes of .npz and .h5: units of the input, domain_from, periodic_from and version.
[[nodiscard]] std::vector<Attribute> attributes_of(std::vector<Attribute> units, const DomainFrom& domain_from);

// Throws Failure for a name that is not UTF-8, which most formats demand.
void check_name(const InputColumn& column);

// Returns the carried columns with their names in the output. Throws Failure when a name occurs twice or is that of an
// array of the file.
[[nodiscard]] std::vector<InputColumn> carried_columns(const std::vector<std::string>& outputs,
                                                       std::vector<InputColumn> columns, bool planar = false);

void write_text(OutputFile& file, const OutputData& data);
void write_npz(OutputFile& file, const OutputData& data);
void write_csv(OutputFile& file, const OutputData& data);
void write_xyz(OutputFile& file, const OutputData& data);
void write_dump(OutputFile& file, const OutputData& data);
[[nodiscard]] bool is_table_column(std::string_view name, bool planar);  // whether a table may hold one of that name
void write_vtu(OutputFile& file, const OutputData& data);
[[nodiscard]] bool is_vtu_array(std::string_view name);  // whether .vtu always holds an array of that name
void write_ply(OutputFile& file, const OutputData& data);
void write_obj(OutputFile& file, const OutputData& data);
void write_glb(OutputFile& file, const OutputData& data);
void write_foam(OutputFile& file, const OutputData& data);
void write_tess(OutputFile& file, const OutputData& data);
void write_msh(OutputFile& file, const OutputData& data);
void write_cgns(OutputFile& file, const OutputData& data);
void write_stl(OutputFile& file, const OutputData& data);
void write_3mf(OutputFile& file, const OutputData& data);
void write_geojson(OutputFile& file, const OutputData& data);

}  // namespace clvotess

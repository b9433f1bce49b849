// The command line, read and checked.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>
#include <votess/diagram.hpp>
#include <votess/fit.hpp>
#include <votess/votess.hpp>

#include "options.hpp"
#include "picture.hpp"
#include "read/frames.hpp"
#include "read/input.hpp"
#include "read/surface.hpp"
#include "write/text_format.hpp"

namespace clvotess {

struct Arguments {
    std::string input;  // file or "-"; empty with --random
    std::string flat;   // the option that says that there are two dimensions, for messages; empty without one
    ReadRequest read;
    std::optional<FrameRange> frames;     // by --frames
    bool hull = false;                    // --box hull
    std::string mesh_file;                // --mesh
    Surface mesh;                         // once load_mesh() has read it
    std::string surface_file;             // --surface
    std::optional<std::uint64_t> remesh;  // --remesh
    double sharp = 40;                    // --sharp
    double gap = 0;                       // --gap
    double min_edge = 0;                  // --min-edge
    bool skip_open = false;               // --open skip
    bool points_alone = false;            // --points
    bool covalent = false;                // --radii covalent
    // Meaning of read.columns, in order: weights or radii, volumes, masses for --density, values for --watershed, then
    // carried columns or field values.
    bool has_weights = false, has_radii = false, has_volumes = false, has_density = false, has_zones = false;
    bool zones_of_density = false;  // --watershed density: no column
    std::optional<double> merge;    // --merge
    std::int32_t alpha = 0;         // copies by --alpha; 0: no alpha complex
    votess::FitOptions fit;         // with --volumes
    std::optional<std::uint64_t> random_count;
    std::uint64_t rng_seed = 1;

    std::optional<votess::GridOptions> to_grid;  // as many columns as --values
    std::string
        query;  // --locate, --probe, --interpolate, --trace or --to-grid; empty: the run makes cells of the points
    std::string queries;  // the file of the queries; empty without one
    votess::NaturalMethod natural = votess::NaturalMethod::sibson;

    std::vector<std::string> outputs;
    TextFormat format{"%i %n"};
    std::optional<PictureArguments> picture;
    Coloring coloring;

    // Arrays that the user or an output wants. options.want may hold more, for --verify and --density.
    votess::Want wanted;
    votess::Options options;
    std::optional<std::array<bool, 3>> periodic;  // by --periodic: axes of the box or edges of the cell

    bool threads_given = false;  // --threads
    std::uint64_t memory = 0;    // --memory in bytes; 0: everything stays in memory
    std::string temporary;       // folder of temporary files

    std::string only;  // a range or file of indices; empty: all cells

    bool verify = false;
    bool json = false;
    bool quiet = false;

    std::vector<const Option*> given;  // on the command line, in the order of the table
    // Returns the first of them that needs one of these; null if none does.
    [[nodiscard]] const Option* find_needing(std::initializer_list<Needs> needs,
                                             const std::vector<std::string>& except = {}) const;

    // Text to print instead of a run, for --help, --version and the like.
    std::string answer;
    bool list_devices = false;
};

// Throws Failure with exit_code::bad_input. Checks nothing else when `answer` is set.
[[nodiscard]] Arguments read_arguments(int count, const char* const* values);

// Reads a count of points up to a maximum, also in the form 1e6. Throws Failure.
[[nodiscard]] std::uint64_t read_count(const std::string& option, const std::string& text, std::uint64_t max);

// Reads the file of --mesh, if that is given, into the options. Throws Failure.
void load_mesh(Arguments& arguments);

// Reads the arguments of voro++ 0.4.6; values[0] is skipped. The output is the .vol file beside the input.
[[nodiscard]] Arguments read_voropp_arguments(int count, const char* const* values);

// Moves seeds on an upper wall out of the box for --voro++: voro++ keeps those on the lower wall and drops those on the
// upper.
void drop_upper_walls(const Arguments& arguments, Input& input);

}  // namespace clvotess

// What -o names. All files are complete before the first of them appears under its name.
#pragma once

#include <span>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "coloring.hpp"
#include "domain.hpp"
#include "read/input.hpp"
#include "write/text_format.hpp"

namespace clvotess {

class OutputFile;

// Before any work: folders that exist and can be written, no file twice, none that is one of the inputs, which may be
// empty or "-".
void check_paths(const std::vector<std::string>& paths, const std::vector<std::string>& inputs);

// That the module is there, and that the path names no device or pipe.
void check_hdf5(const std::string& path);

// The same, and known extensions.
void check_outputs(const std::vector<std::string>& paths, const std::vector<std::string>& inputs);

[[nodiscard]] bool is_text_output(const std::string& path);
[[nodiscard]] bool carries_columns(const std::string& path);
[[nodiscard]] bool is_colored(const std::string& path);

// Adds to `want` the arrays that a file of this extension holds; text is asked by its format.
void add_output_needs(const std::string& path, votess::Want& want);

struct OutputData {
    const Input& input;
    const votess::Tessellation& tessellation;
    const votess::Want& wanted;  // arrays for .npz and .h5; the tessellation may hold more
    const TextFormat& format;
    std::span<const double> radii;  // for %r; empty when there are none
    const DomainFrom& domain_from;
    const std::vector<InputColumn>& carried;  // columns of the input, behind what each file holds of a cell
    const Coloring& coloring;                 // of .glb
    bool says_sizes = false;                  // on stderr, of a file that may be large, before it is written
};

// What .npz and .h5 hold once: the units of the input, domain_from, periodic_from and version.
[[nodiscard]] std::vector<Attribute> attributes_of(std::vector<Attribute> units, const DomainFrom& domain_from);

// Columns that go from the input into the output, and the density. Throws Failure when a file has an array of that name
// itself.
[[nodiscard]] std::vector<InputColumn> carried_columns(const std::vector<std::string>& outputs,
                                                       std::vector<InputColumn> columns);

void write_outputs(const std::vector<std::string>& paths, const OutputData& data);

void write_text(OutputFile& file, const OutputData& data);
void write_npz(OutputFile& file, const OutputData& data);
void write_vtu(OutputFile& file, const OutputData& data);
[[nodiscard]] bool is_vtu_array(std::string_view name);  // of cells, that .vtu always holds
void write_ply(OutputFile& file, const OutputData& data);
void write_obj(OutputFile& file, const OutputData& data);
void write_glb(OutputFile& file, const OutputData& data);

}  // namespace clvotess

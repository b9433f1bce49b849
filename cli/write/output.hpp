// What -o names. All files are complete before the first of them appears under its name.
#pragma once

#include <span>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "read/input.hpp"
#include "write/text_format.hpp"

namespace clvotess {

class OutputFile;

// Before any work: known extensions, folders that exist and can be written, no file twice, none that is the input.
void check_outputs(const std::vector<std::string>& paths, const std::string& input);

[[nodiscard]] bool is_text_output(const std::string& path);

// Adds to `want` the arrays that a file of this extension holds; text is asked by its format.
void add_output_needs(const std::string& path, votess::Want& want);

struct OutputData {
    const Input& input;
    const votess::Tessellation& tessellation;
    const votess::Want& wanted;  // arrays for .npz and .h5; the tessellation may hold more
    const TextFormat& format;
    bool radii = false;  // whether Input::column holds radii, for %r
};

void write_outputs(const std::vector<std::string>& paths, const OutputData& data);

void write_text(OutputFile& file, const OutputData& data);
void write_npz(OutputFile& file, const OutputData& data);
void write_vtu(OutputFile& file, const OutputData& data);
void write_ply(OutputFile& file, const OutputData& data);
void write_obj(OutputFile& file, const OutputData& data);

}  // namespace clvotess

// What -o names. All files are complete before the first of them appears under its name.
#pragma once

#include <span>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "input.hpp"
#include "text_format.hpp"

namespace clvotess {

class OutputFile;

// Before any work: known extensions, folders that exist and can be written, no file twice, none that is the input.
void check_outputs(const std::vector<std::string>& paths, const std::string& input);

[[nodiscard]] bool is_text_output(const std::string& path);

struct OutputData {
    const Input& input;
    const votess::Tessellation& tessellation;
    const votess::Want& wanted;  // arrays for .npz; the tessellation may hold more
    const TextFormat& format;
};

void write_outputs(const std::vector<std::string>& paths, const OutputData& data);

void write_text(OutputFile& file, const OutputData& data);
void write_npz(OutputFile& file, const OutputData& data);

}  // namespace clvotess

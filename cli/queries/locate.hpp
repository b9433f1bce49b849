// --locate: which cell holds each point of another file. No cell is made.
#pragma once

#include <string>

#include "arguments/arguments.hpp"

namespace clvotess {

// The rest of the command line is checked. Returns what to print, the summary or its JSON object; empty with --quiet.
[[nodiscard]] std::string run_locate(const Arguments& arguments);

// Before any work: .npy, .txt, devices, pipes and stdout, as check_outputs().
void check_located_outputs(const Arguments& arguments);

}  // namespace clvotess

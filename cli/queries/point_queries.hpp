// --locate, --probe, --interpolate and --trace: queries at the points or rays of another file.
#pragma once

#include <string>

#include "arguments/arguments.hpp"

namespace clvotess {

// Each checks the outputs of its option, after the rest of the command line. Throws Failure.
void check_located_outputs(const Arguments& arguments);
void check_probed_outputs(const Arguments& arguments);  // after check_outputs()
void check_interpolated_outputs(const Arguments& arguments);
void check_traced_outputs(const Arguments& arguments);

// Each runs its query and returns the text to print: the summary or its JSON object; empty with --quiet.
[[nodiscard]] std::string run_locate(const Arguments& arguments);
[[nodiscard]] std::string run_probe(const Arguments& arguments);
[[nodiscard]] std::string run_interpolate(const Arguments& arguments);
[[nodiscard]] std::string run_trace(const Arguments& arguments);

}  // namespace clvotess

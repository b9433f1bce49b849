// --interpolate: a field at the points of another file, from its values at the seeds.
#pragma once

#include <string>

#include "arguments/arguments.hpp"

namespace clvotess {

// The rest of the command line is checked. Returns what to print, the summary or its JSON object; empty with --quiet.
[[nodiscard]] std::string run_interpolate(const Arguments& arguments);

// Some outputs, of kinds that hold numbers alone.
void check_interpolated_outputs(const Arguments& arguments);

}  // namespace clvotess

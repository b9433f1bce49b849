// --to-grid: values of the points on a regular grid.
#pragma once

#include <string>

#include "arguments/arguments.hpp"

namespace clvotess {

// The grid of --to-grid, --shape and --project. Lengths that --shape does not name are 0.
[[nodiscard]] votess::GridOptions read_grid(const Typed& typed);
// Some outputs, or a picture, of kinds that hold a grid.
void check_grid(const Arguments& arguments);

// Runs the query and returns the text to print: the summary or its JSON object; empty with --quiet.
[[nodiscard]] std::string run_to_grid(const Arguments& arguments);

}  // namespace clvotess

// --to-grid: what the points carry, on a regular grid.
#pragma once

#include <optional>
#include <string>

#include "arguments/arguments.hpp"

namespace clvotess {

// Options as typed.
struct TypedGrid {
    std::optional<std::string> method, shape, project;
};

// The grid that they ask for. has_values: whether --values is there.
[[nodiscard]] votess::GridOptions read_grid(const TypedGrid& typed, bool has_values);
// Some outputs, or a picture, of kinds that hold a grid.
void check_grid(const Arguments& arguments);

// The rest of the command line is checked. Returns what to print, the summary or its JSON object; empty with --quiet.
[[nodiscard]] std::string run_to_grid(const Arguments& arguments);

}  // namespace clvotess

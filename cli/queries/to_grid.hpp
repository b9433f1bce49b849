// --to-grid: values of the points on a regular grid.
#pragma once

#include <optional>
#include <string>

#include "arguments/arguments.hpp"

namespace clvotess {

// Options as typed.
struct TypedGrid {
    std::optional<std::string> method, shape, project;
};

// Returns the grid that the options describe. has_values: with --values.
[[nodiscard]] votess::GridOptions read_grid(const TypedGrid& typed, bool has_values);
// Throws Failure unless there are outputs or a picture that can hold the grid.
void check_grid(const Arguments& arguments);

// Runs the query and returns the text to print: the summary or its JSON object; empty with --quiet.
[[nodiscard]] std::string run_to_grid(const Arguments& arguments);

}  // namespace clvotess

// --to-grid: values of the points on a regular grid.
#pragma once

#include <memory>

#include "arguments/arguments.hpp"
#include "queries/query_run.hpp"

namespace clvotess {

// The grid of --to-grid, --shape and --project. Lengths that --shape does not name are 0.
[[nodiscard]] votess::GridOptions read_grid(const Typed& typed);
// Some outputs, or a picture, of kinds that hold a grid.
void check_grid(const Arguments& arguments);

[[nodiscard]] std::unique_ptr<Query> make_grid_query(const Arguments& arguments);

}  // namespace clvotess

// --locate, --probe, --interpolate and --trace: queries at the points or rays of another file.
#pragma once

#include <memory>

#include "arguments/arguments.hpp"
#include "queries/query_run.hpp"

namespace clvotess {

// Checks the outputs of the query of the arguments, after the rest of the command line. Throws Failure.
void check_query_outputs(const Arguments& arguments);

[[nodiscard]] std::unique_ptr<Query> make_point_query(const Arguments& arguments);

}  // namespace clvotess

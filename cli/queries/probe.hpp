// --probe: the cell that each point of another file would have among the seeds.
#pragma once

#include <string>

#include "arguments/arguments.hpp"

namespace clvotess {

// The rest of the command line is checked. Returns what to print, the summary or its JSON object; empty with --quiet.
[[nodiscard]] std::string run_probe(const Arguments& arguments);

// Behind check_outputs(): some, and none that joins the cells.
void check_probed_outputs(const Arguments& arguments);

}  // namespace clvotess

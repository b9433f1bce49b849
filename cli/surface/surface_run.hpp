// Cells on a surface by --surface, and its new mesh by --remesh.
#pragma once

#include <string>

#include "arguments/arguments.hpp"
#include "arguments/typed.hpp"

namespace clvotess {

// Throws Failure for an option that a run with --surface does not use.
void refuse_beside_surface(const Arguments& arguments);

// Reads the options of such a run. Throws Failure.
void read_surface_options(const Typed& typed, Arguments& arguments);

// Returns the text to print: the summary or its JSON object; empty with --quiet.
[[nodiscard]] std::string run_on_surface(const Arguments& arguments);

}  // namespace clvotess

// --memory: points larger than memory, read and written in pieces.
#pragma once

#include <string>

#include "arguments/arguments.hpp"
#include "progress.hpp"
#include "summary.hpp"

namespace clvotess {

// Reads --memory and --temporary. Throws Failure, also for options that --memory cannot serve.
void read_memory(const Typed& typed, Arguments& arguments);

// Throws Failure for arguments that do not work in pieces.
void check_streamed(const Arguments& arguments);

// Writes the outputs unless verification fails. Returns the summary without its total time.
[[nodiscard]] Summary run_streamed(const Arguments& arguments, Clock::time_point run_began);

}  // namespace clvotess

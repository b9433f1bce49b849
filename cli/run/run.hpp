// A run that makes cells: frames, the cells of each, their outputs.
#pragma once

#include "arguments/arguments.hpp"
#include "progress.hpp"
#include "summary.hpp"

namespace clvotess {

// Throws Failure for options that mean nothing for several frames.
void check_frames(const Arguments& arguments);

// Makes and writes the cells of all frames. The summary of several has their sums. Without --frames it may state a
// failed check, after which nothing is written.
[[nodiscard]] Summary run_cells(const Arguments& arguments, Clock::time_point run_began);

}  // namespace clvotess

// --memory: points larger than memory, from a file that is read in pieces into one that is written in pieces.
#pragma once

#include <optional>
#include <string>

#include "arguments/arguments.hpp"
#include "progress.hpp"
#include "summary.hpp"

namespace clvotess {

// The values of --memory and --temporary. Throws Failure.
void read_memory(const std::optional<std::string>& memory, const std::optional<std::string>& temporary,
                 Arguments& arguments);

// After reading the arguments: refuses what cannot be had in pieces. Throws Failure.
void check_streamed(const Arguments& arguments);

// Writes the outputs unless verification fails, and returns what there is to tell, but for the time in all.
[[nodiscard]] Summary run_streamed(const Arguments& arguments, Progress::Clock::time_point run_began);

}  // namespace clvotess

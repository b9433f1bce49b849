// Options of clvotess that clvotess-mpi answers itself or refuses.
#pragma once

#include <string>

#include "arguments/arguments.hpp"

namespace clvotess {

// Returns the answer to --help, --version and the like. Throws Failure for options that only clvotess has.
[[nodiscard]] std::string answer_of_ranks(int count, const char* const* values);

// Throws Failure for the first option that ranks cannot do.
void refuse_for_ranks(const Arguments& arguments);

}  // namespace clvotess

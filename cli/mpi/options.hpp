// What clvotess-mpi answers, and refuses, of the options of clvotess.
#pragma once

#include <string>

#include "arguments/arguments.hpp"

namespace clvotess {

// The answer to --help, --version and their kin, which clvotess would give another way. Throws Failure for those that
// only clvotess has.
[[nodiscard]] std::string answer_of_ranks(int count, const char* const* values);

// Throws Failure with the first option that is refused, and why.
void refuse_for_ranks(const Arguments& arguments);

}  // namespace clvotess

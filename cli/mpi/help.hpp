// What clvotess-mpi says of itself.
#pragma once

#include <string>

namespace clvotess {

// The answer to --help, --version and their kin, which clvotess would give another way. Throws Failure for those that
// only clvotess has.
[[nodiscard]] std::string answer_of_ranks(int count, const char* const* values);

}  // namespace clvotess

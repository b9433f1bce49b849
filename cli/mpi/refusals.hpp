// What clvotess does and ranks cannot.
#pragma once

#include "arguments/arguments.hpp"

namespace clvotess {

// Throws Failure with the first option that is refused, and why.
void refuse_for_ranks(const Arguments& arguments);

}  // namespace clvotess

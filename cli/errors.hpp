// How errors of the library end the program.
#pragma once

#include <votess/votess.hpp>

#include "failure.hpp"

namespace clvotess {

[[nodiscard]] inline int exit_code_of(votess::ErrorCode code) {
    const bool users = code == votess::ErrorCode::invalid_argument || code == votess::ErrorCode::unsupported;
    return users ? exit_code::bad_input : exit_code::runtime_failure;
}

}  // namespace clvotess

// The two errors that most files throw.
#pragma once

#include <string>

#include "votess/votess.hpp"

namespace votess {

[[noreturn]] inline void refuse(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, message);
}

[[noreturn]] inline void bug(const std::string& what) {
    throw Error(ErrorCode::internal, "a bug in votess, please report it: " + what);
}

}  // namespace votess

// The rows of the input that a rank reads, or is dealt.
#pragma once

#include <cstdint>

#include "arguments/arguments.hpp"
#include "mpi/ranks.hpp"
#include "read/input.hpp"

namespace clvotess {

struct InputShare {
    Input input;              // the rows of this rank; what belongs to the whole file all ranks have
    std::uint64_t first = 0;  // row of the file that they begin with
    std::uint64_t rows = 0;   // of the file
    bool has_ids = false;     // on some rank: those without rows have none
};

// Collective. Ranks have consecutive rows, about as many each.
[[nodiscard]] InputShare read_share(const Ranks& ranks, const Arguments& arguments);

}  // namespace clvotess

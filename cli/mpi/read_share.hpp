// The rows of the input that a rank gets.
#pragma once

#include <cstdint>

#include "arguments/arguments.hpp"
#include "mpi/ranks.hpp"
#include "read/input.hpp"

namespace clvotess {

struct InputShare {
    Input input;              // the rows of this rank; properties of the whole file are on all ranks
    std::uint64_t first = 0;  // its first row in the file
    std::uint64_t rows = 0;   // in the file
    bool has_ids = false;     // on any rank; a rank without rows has none
};

// Collective. Returns consecutive rows, about equally many for each rank.
[[nodiscard]] InputShare read_share(const Ranks& ranks, const Arguments& arguments);

}  // namespace clvotess

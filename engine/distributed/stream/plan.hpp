// How many blocks a stream needs for its memory, and how much room it takes on disk.
#pragma once

#include <cstdint>

#include "votess/votess.hpp"

namespace votess::stream {

// The properties of a run that its memory depends on.
struct Kind {
    Want want;
    bool periodic = false, weighted = false;
    bool singles = false;   // float32 holds all coordinates
    bool verified = false;  // the cells are proven
};

// Returns the least number of blocks of which the largest fits.
[[nodiscard]] std::size_t blocks_for(std::uint64_t memory, std::uint64_t seeds, const Kind& kind);
// Returns an estimate of the bytes of all temporary files.
[[nodiscard]] std::uint64_t bytes_on_disk(std::uint64_t seeds, std::size_t blocks, const Kind& kind);

}  // namespace votess::stream

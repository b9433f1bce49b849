// How many blocks fit the memory that a run in blocks may take one after the other, and how much room they take on
// disk.
#pragma once

#include <cstdint>

#include "votess/votess.hpp"

namespace votess::stream {

// What a run is like, as far as its memory depends on it.
struct Kind {
    Want want;
    bool periodic = false, weighted = false;
};

// So many that the largest fits.
[[nodiscard]] std::size_t blocks_for(std::uint64_t memory, std::uint64_t seeds, const Kind& kind);
// What all temporary files take, about, for rows are not known yet.
[[nodiscard]] std::uint64_t bytes_on_disk(std::uint64_t seeds, std::size_t blocks, const Kind& kind);

}  // namespace votess::stream

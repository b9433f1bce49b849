// How much memory a contestant needs at most, in a process of its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "measure.hpp"

namespace bench {

struct MemoryTable {
    std::vector<std::string> inputs, wants;
    std::vector<std::size_t> sizes;
    std::vector<unsigned> threads;
    std::uint64_t rng_seed = 1;
    std::string json;  // empty: none
};

// Prints peak resident memory in bytes a point, above that of the process with its input. Returns the exit code: 1 when
// a peer failed. Linux only: throws std::runtime_error elsewhere. Call it before the process starts threads or a peer
// runs.
int run_memory_table(const MemoryTable& table, const Peers& peers, const std::vector<PeerVersion>& versions);

}  // namespace bench

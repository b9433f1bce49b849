// How much of a fresh call a Tessellator takes that follows moving seeds.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "measure.hpp"

namespace bench {

struct MovingTable {
    std::vector<std::string> inputs, wants;
    std::vector<std::size_t> sizes;
    int steps = 5;
    std::uint64_t rng_seed = 1;
    std::string json;  // empty: none
};

// Prints the CPU time of a call with Options::follow over that of one without, one thread, by how far the seeds move
// before each call. Returns the exit code: 1 when an answer is not that of a fresh call.
int run_moving_table(const MovingTable& table, const std::vector<PeerVersion>& versions);

}  // namespace bench

// The speeds that votess sets out to reach, each a ratio of two medians.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "measure.hpp"

namespace bench {

struct Goals {
    // Additional peers of the goals.
    static std::vector<std::string> instructions() { return {"baseline", "avx2", "avx512"}; }

    std::size_t small = 100'000, large = 1'000'000;  // seeds; other numbers only try the program out
    std::string file;                                // file:PATH, or empty
    Repeats repeats;                                 // count 0: 5, of large inputs 3
    std::uint64_t rng_seed = 1;
    bool table = false;   // the table of the page on benchmarks instead: Voro++, and inputs beside plain ones
    std::string json;     // empty: none
    bool strict = false;  // a goal that is not met, or could not be measured, makes the exit code 1
    bool check = false;   // so do answers that disagree where they must not
};

// Prints a line a goal. Returns the exit code.
int run_goals(const Goals& goals, const Peers& peers, const std::vector<PeerVersion>& versions);

}  // namespace bench

// How much Tessellator::update() gains over tessellate() for seeds that move.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace bench {

struct UpdateTable {
    std::vector<std::size_t> sizes;
    std::vector<double> distances{0.01, 0.1, 1};  // that each seed moves between two calls, in mean spacings
    unsigned threads = 1;
    int repeats = 9;
    std::uint64_t rng_seed = 1;
};

// Prints processor time of both, their ratio, and whether the lists were equal. Returns the exit code: 1 when some were
// not.
int run_update_table(const UpdateTable& table);

}  // namespace bench

// votess on one device: rates per stage on many inputs, each checked against the CPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace bench {

struct GpuTable {
    std::string device = "gpu";  // as in votess::Options
    std::vector<std::size_t> sizes{10'000, 100'000, 1'000'000, 10'000'000};
    std::vector<std::string> inputs{"uniform",  "clustered", "lattice", "bcc",
                                    "periodic", "triclinic", "radii",   "octahedron"};
    std::vector<std::string> wants{"neighbors", "full"};
    // Variants, each with each, of the first three inputs; of the others the first alone.
    std::vector<std::string> kernels{"invocation", "subgroup"};  // or automatic
    std::vector<unsigned> local_sizes{32, 128};                  // invocations of a work-group
    std::vector<std::string> numbers{"float64", "float32"};      // that measure cells; or automatic
    unsigned threads = 0;
    int repeats = 5;
    double limit = 120;
    double check_limit = 1e5;  // seeds
    std::uint64_t rng_seed = 1;
    std::string json;  // empty: gpu-<device>-<date>.json
};

// Prints the table and rewrites the JSON file after every row, so that an interrupted run leaves the rows so far.
// Returns 0, or 1 when a result was wrong or a run failed. Throws votess::Error when the device is missing.
int run_gpu_table(const GpuTable& table);

}  // namespace bench

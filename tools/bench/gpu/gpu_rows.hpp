// A row of the GPU table as text and as JSON.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "bench.hpp"
#include "gpu/gpu_table.hpp"

namespace bench {

struct GpuRow {
    std::string input;
    std::size_t n = 0;
    Want want = Want::neighbors;
    std::string kernel;
    unsigned local_size = 0;
    std::string numbers;          // arithmetic of volumes: float64, or float32 for sums of two; automatic
    double first_seconds = 0;     // of the warm-up, which opens the device and compiles the pipelines
    std::vector<double> seconds;  // each repeat
    std::vector<votess::StageSeconds> stages;
    votess::Stats stats;  // of the last repeat
    std::uint64_t peak_memory = 0;
    std::string check;  // "= CPU", "not compared" or the fault
    double volume_error = 0;
    bool wrong = false;
    std::string note;  // why there is no time

    [[nodiscard]] double best() const { return *std::min_element(seconds.begin(), seconds.end()); }
    [[nodiscard]] double rate(double s) const { return static_cast<double>(n) / s / 1e6; }
};

void print_head(const GpuTable& table);
void print(const GpuRow& row);
// The variant with the best median of each input, size and want.
void print_best(const std::vector<GpuRow>& rows);

// gpu-DEVICE-DATE.json, with local time.
std::string gpu_file_name(const std::string& device);
// frames: of JSON.
void write(const std::string& file, const votess::DeviceInfo& device, unsigned threads, const std::vector<GpuRow>& rows,
           const std::vector<std::string>& frames);

}  // namespace bench

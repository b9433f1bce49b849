// Frames recorded into a program's own command buffer: seeds and results stay on the device.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "bench.hpp"

namespace host {
class Device;
}

namespace bench {

struct FrameRow {
    std::string input;
    std::size_t n = 0;
    std::string kernel;
    bool rows = false;                          // neighbors
    bool geometry = false;                      // volumes and centroids
    double first_seconds = 0;                   // of the warm-up
    std::vector<double> seconds;                // each repeat, from submission to the end
    std::vector<std::array<double, 4>> stages;  // each repeat: upload, sort, hierarchy, cells; of the device
    std::uint64_t unresolved = 0;               // cells left to resolve()
    std::uint64_t device_bytes = 0;             // of all buffers
    std::string check;                          // "= CPU", "not compared" or what is wrong
    bool wrong = false;
    std::string note;  // why there is no time
};

class Frames {
public:
    // On the Vulkan device of that name.
    explicit Frames(const std::string& device_name);
    ~Frames();

    // Fills in a row with its input, size, rows and geometry. compare: certified rows with the CPU's, and volumes.
    void measure(FrameRow& row, const Input& input, int repeats, bool compare) const;

private:
    std::unique_ptr<host::Device> device_;
};

void print_frames_head();
void print(const FrameRow& row);
std::string json(const FrameRow& row);

}  // namespace bench

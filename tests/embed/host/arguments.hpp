// What the user asked for.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace host {

struct Arguments {
    std::uint32_t frames = 8;
    std::uint32_t seeds = 2000;
    std::uint32_t width = 640, height = 480;
    std::uint32_t samples = 2;  // per pixel, along each axis
    std::uint32_t plans = 1;
    std::string output;          // folder for pictures; empty: none are written
    std::string device;          // part of a name, "lavapipe", or an index; empty: the first that will do
    std::uint32_t validate = 0;  // 1: under the validation layer, 2: which looks for missing barriers too
    bool float64 = true;
    bool probe = true;
    bool help = false;
};

// Its text is for the user; exit code 2.
struct BadUsage : std::runtime_error {
    using std::runtime_error::runtime_error;
};

extern const char* const usage;
[[nodiscard]] Arguments read_arguments(int argc, char** argv);

}  // namespace host

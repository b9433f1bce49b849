// The command line, read and checked.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "picture.hpp"
#include "read/input.hpp"
#include "write/text_format.hpp"

namespace clvotess {

struct Arguments {
    std::string input;  // file or "-"; empty with --random
    ReadRequest read;
    // The first column that `read` names holds weights or radii, the next one is to be divided by the volumes, the rest
    // is carried into the output.
    bool has_weights = false, has_radii = false, has_density = false;
    std::optional<std::uint64_t> random_count;
    std::uint64_t rng_seed = 1;

    std::vector<std::string> outputs;
    TextFormat format{"%i %n"};
    std::optional<PictureArguments> picture;

    // Arrays that the user or an output wants, and the options of the run, where --verify may add to `options.want`.
    votess::Want wanted;
    votess::Options options;
    std::optional<std::array<bool, 3>> periodic;  // axes of the box, or edges of the cell, that the user names

    bool verify = false;
    bool json = false;
    bool quiet = false;

    bool help = false;
    bool version = false;
    bool list_devices = false;
};

// Throws Failure with exit_code::bad_input. After --help, --version or --list-devices nothing else is checked.
[[nodiscard]] Arguments read_arguments(int count, const char* const* values);

extern const char* const help_text;

}  // namespace clvotess

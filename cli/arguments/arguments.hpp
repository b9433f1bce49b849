// The command line, read and checked.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>
#include <votess/diagram.hpp>
#include <votess/votess.hpp>

#include "picture.hpp"
#include "read/input.hpp"
#include "write/text_format.hpp"

namespace clvotess {

struct Arguments {
    std::string input;  // file or "-"; empty with --random
    ReadRequest read;
    // The first column that `read` names holds weights or radii, the next one is to be divided by the volumes, the rest
    // is carried into the output, or makes a field.
    bool has_weights = false, has_radii = false, has_density = false;
    std::optional<std::uint64_t> random_count;
    std::uint64_t rng_seed = 1;

    std::optional<votess::GridOptions> to_grid;  // of --values, as many columns as these have
    std::string locate, probe, interpolate;      // the file of the queries of one of these options; else empty
    votess::NaturalMethod natural = votess::NaturalMethod::sibson;

    std::vector<std::string> outputs;
    TextFormat format{"%i %n"};
    std::optional<PictureArguments> picture;
    Coloring coloring;

    // Arrays that the user or an output wants, and the options of the run, where --verify may add to `options.want`.
    votess::Want wanted;
    votess::Options options;
    std::optional<std::array<bool, 3>> periodic;  // axes of the box, or edges of the cell, that the user names

    bool threads_given = false;  // --threads
    std::uint64_t memory = 0;    // bytes, of --memory; 0: all is in memory
    std::string temporary;       // folder

    bool verify = false;
    bool json = false;
    bool quiet = false;

    // What to print instead of a run: for --help, --version and their kin.
    std::string answer;
    bool list_devices = false;
};

// Throws Failure with exit_code::bad_input. When there is something to print instead of a run, nothing else is checked.
[[nodiscard]] Arguments read_arguments(int count, const char* const* values);

// The same from arguments of voro++ 0.4.6, values[0] aside. The output is the .vol file beside the input.
[[nodiscard]] Arguments read_voropp_arguments(int count, const char* const* values);

}  // namespace clvotess

// --frames: the cells of several frames of a file, in one pass and with memory for a few frames.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "arguments/arguments.hpp"
#include "read/frames.hpp"
#include "summary.hpp"

namespace clvotess {

// Reads the value of --frames. Throws Failure.
[[nodiscard]] FrameRange read_frame_range(const std::string& text);

// Throws Failure for options that mean nothing for several frames.
void check_frames(const Arguments& arguments);

// Writes the points of all frames of --frames to stdout. A line of JSON describes each: frame, timestep, points (N),
// ids (whether there are any), species (bytes of a text with blanks between them, or 0), columns (names and widths),
// units, and the domain as the file states it. Points, ids, columns and species follow, as float64 and int64 of this
// machine.
void write_points(const Arguments& arguments);

// Makes and writes the cells of all frames of --frames. The summary has their sums.
[[nodiscard]] Summary run_frames(const Arguments& arguments, std::chrono::steady_clock::time_point run_began);

}  // namespace clvotess

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

// Writes the points of all frames of --frames to stdout. A line of JSON comes before each frame. Its members:
//   - frame, timestep, points: number of the frame, its timestep and number of points
//   - ids: whether the frame has ids
//   - species: bytes of the text that holds them, with blanks between them
//   - columns: names and widths
//   - units, and the domain that the file states
// The arrays follow: points, ids, columns, species. Numbers are float64 and int64 of this machine.
void write_points(const Arguments& arguments);

// Makes and writes the cells of all frames of --frames. The summary has their sums.
[[nodiscard]] Summary run_frames(const Arguments& arguments, std::chrono::steady_clock::time_point run_began);

}  // namespace clvotess

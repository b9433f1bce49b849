// The frames of a run: one, or those of --frames in one pass and with memory for a few.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "arguments/arguments.hpp"
#include "failure.hpp"
#include "read/frames.hpp"
#include "read/input.hpp"

namespace clvotess {

// Reads the value of --frames. Throws Failure.
[[nodiscard]] FrameRange read_frame_range(const std::string& text);

// Reads the frames of a run, one after the other.
class Frames {
public:
    explicit Frames(const Arguments& arguments);

    // Returns the next frame; nothing after the last. Throws Failure if the range has no frame.
    [[nodiscard]] std::optional<Input> next();
    // Returns the share of the range that was read; 0 where that is unknown.
    [[nodiscard]] double fraction() const;
    [[nodiscard]] double seconds() const { return seconds_; }  // of reading

private:
    [[nodiscard]] std::optional<Input> read();

    const Arguments& arguments_;
    std::unique_ptr<InputFrames> file_;  // with --frames
    bool any_ = false;
    double seconds_ = 0;
};

// Calls work(), and names the frame in its errors, if the run has several.
template <class Work>
auto in_frame(const Arguments& arguments, std::optional<std::uint64_t> number, const Work& work) {
    if (!arguments.frames) return work();
    const std::string begin = "frame " + std::to_string(number.value_or(0)) + ": ";
    try {
        return work();
    } catch (const Failure& failure) {
        throw Failure(failure.code(), begin + failure.what());
    } catch (const votess::Error& error) {
        if (error.code() == votess::ErrorCode::cancelled) throw;
        throw votess::Error(error.code(), begin + error.what());
    }
}

// Writes the points of all frames of --frames to stdout. A line of JSON comes before each frame. Its members:
//   - frame, timestep, points: number of the frame, its timestep and number of points
//   - ids: whether the frame has ids
//   - species: bytes of the text that holds them, with blanks between them
//   - columns: names and widths
//   - units, and the domain that the file states
// The arrays follow: points, ids, columns, species. Numbers are float64 and int64 of this machine.
void write_points(const Arguments& arguments);

}  // namespace clvotess

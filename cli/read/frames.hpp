// Frames of a file, one after the other, in one pass and with memory for one.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "failure.hpp"
#include "read/input.hpp"

namespace clvotess {

class InputFrames {
public:
    virtual ~InputFrames() = default;
    // Reads the next frame. Returns false at the end. Throws Failure for a frame that cannot be read.
    virtual bool next(Input& frame) = 0;
    // Passes over the next frame. Returns false at the end.
    virtual bool skip() = 0;
    // Reads the last frame, from the current one on. Returns false without one.
    virtual bool last(Input& frame) = 0;
    // Returns how many frames follow the current one; nothing if counting would take long. Throws Failure if something
    // else follows it. No other call may follow.
    virtual std::optional<std::uint64_t> count_rest() = 0;
    // Returns the share of the file that was read; 0 where that is unknown.
    [[nodiscard]] virtual double fraction() const = 0;
    [[nodiscard]] virtual const std::string& name() const = 0;  // of the file, for messages

    [[nodiscard]] std::uint64_t passed() const noexcept { return passed_; }  // frames before the next one

protected:
    std::uint64_t passed_ = 0;
};

// The frames of --frames: from `begin` to before `end`, each `step`-th; or the last alone.
struct FrameRange {
    std::uint64_t begin = 0;
    std::optional<std::uint64_t> end;
    std::uint64_t step = 1;
    bool last = false;
    std::string text = "all";  // as given, for messages

    // Returns whether frame `number`, or any after it, is in the range.
    [[nodiscard]] bool holds(std::uint64_t number) const noexcept {
        return number >= begin && ends_after(number) && (number - begin) % step == 0;
    }
    [[nodiscard]] bool ends_after(std::uint64_t number) const noexcept { return !end || number < *end; }
};

// Opens a file. One without frames counts as one frame. Throws Failure.
[[nodiscard]] std::unique_ptr<InputFrames> open_frames(const std::string& path, const ReadRequest& request);

// Returns a frame of the file. Its note states which one it is, and of how many. Throws Failure if it is missing.
[[nodiscard]] Input read_frame(InputFrames& frames, std::uint64_t number);

// Returns the note of a frame for the summary. frames: their number, if it is known.
[[nodiscard]] std::string note_of_frame(std::uint64_t number, const std::optional<std::uint64_t>& frames,
                                        const std::string& timestep);

// Returns the error for a range without a frame.
[[nodiscard]] Failure no_frame(const InputFrames& frames, const std::string& range);

// Returns the error for a file that holds no frames.
[[nodiscard]] Failure without_frames(const std::string& name);

// Opens a file without frames as one frame.
[[nodiscard]] std::unique_ptr<InputFrames> one_frame(const std::string& path, const ReadRequest& request);
[[nodiscard]] std::unique_ptr<InputFrames> open_dump_frames(std::unique_ptr<TextSource> source,
                                                            const ReadRequest& request);
// Returns nothing for plain rows; `head` is their begin then.
[[nodiscard]] std::unique_ptr<InputFrames> open_xyz_frames(std::unique_ptr<TextSource>& source,
                                                           const ReadRequest& request, std::string& head);

}  // namespace clvotess

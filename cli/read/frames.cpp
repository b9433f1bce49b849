#include "read/frames.hpp"

#include <algorithm>
#include <utility>

namespace clvotess {
namespace {

// A file without frames, as one of them.
class OneFrame : public InputFrames {
public:
    OneFrame(std::string path, ReadRequest request) : path_(std::move(path)), request_(std::move(request)) {}

    bool next(Input& frame) override {
        if (passed_ > 0) return false;
        frame = read_input(path_, request_);
        frame.frame = passed_++;
        return true;
    }
    bool skip() override { return passed_ == 0 && ++passed_ > 0; }
    bool last(Input& frame) override { return next(frame); }
    std::optional<std::uint64_t> count_rest() override { return 1 - std::min<std::uint64_t>(passed_, 1); }
    [[nodiscard]] double fraction() const override { return static_cast<double>(std::min<std::uint64_t>(passed_, 1)); }
    [[nodiscard]] const std::string& name() const override { return path_; }

private:
    std::string path_;
    ReadRequest request_;
};

}  // namespace

Failure without_frames(const std::string& name) {
    return bad_input(name + ": --frame needs a file with frames, but this one has none: leave it out");
}

Failure no_frame(const InputFrames& frames, const std::string& range) {
    if (frames.passed() == 0) return bad_input(frames.name() + ": the file ends before the atoms of a frame");
    return bad_input(frames.name() + ": frame " + range + " is missing, the file has " +
                     std::to_string(frames.passed()) + ", counted from 0");
}

Input read_frame(InputFrames& frames, std::uint64_t number) {
    while (frames.passed() < number && frames.skip()) {
    }
    Input input;
    if (frames.passed() < number || !frames.next(input)) throw no_frame(frames, std::to_string(number));
    const auto rest = frames.count_rest();
    input.note = note_of_frame(number, rest ? std::optional(number + 1 + *rest) : std::nullopt, input.timestep);
    return input;
}

std::string note_of_frame(std::uint64_t number, const std::optional<std::uint64_t>& frames,
                          const std::string& timestep) {
    std::string note;
    if (frames != 1u) {
        note = "frame " + std::to_string(number + 1) + " of " + (frames ? std::to_string(*frames) : "several") +
               " (--frame " + std::to_string(number) + ")";
    }
    if (!timestep.empty()) note += (note.empty() ? "timestep " : ", timestep ") + timestep;
    return note;
}

std::unique_ptr<InputFrames> one_frame(const std::string& path, const ReadRequest& request) {
    return std::make_unique<OneFrame>(path, request);
}

}  // namespace clvotess

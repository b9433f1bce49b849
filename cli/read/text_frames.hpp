// Frames of a text: FrameText finds each, and a reader of the format reads it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "read/frame_text.hpp"
#include "read/frames.hpp"

namespace clvotess {

// Reader: made from a name and a request. read_frame(text) returns the frame in a text or throws Failure.
// skip_frame(text) reads its header alone.
template <class Reader>
class TextFrames : public InputFrames {
public:
    // head: text that was read from the source before.
    TextFrames(std::unique_ptr<TextSource> source, FrameKind kind, const ReadRequest& request, std::string head = {})
        : source_(std::move(source)), text_(*source_, kind, std::move(head)), reader_(source_->name(), request) {}

    bool next(Input& frame) override {
        if (!find()) return false;
        frame = reader_.read_frame(text_.text());
        end(frame);
        return true;
    }

    bool skip() override {
        if (!find()) return false;
        if (found_ != FrameText::Found::whole) (void)reader_.read_frame(text_.text());  // throws
        reader_.skip_frame(text_.text());
        reader_.lines().go_on({});
        lines_before_ += text_.lines();
        reader_.lines().set_line(lines_before_);
        ++passed_;
        return true;
    }

    bool last(Input& frame) override {
        std::string kept;
        std::size_t line = lines_before_;
        bool any = false;
        for (; find(); any = true, ++passed_) {
            if (any) reader_.skip_frame(kept);
            kept.assign(text_.text());
            line = lines_before_;
            lines_before_ += text_.lines();
            if (found_ != FrameText::Found::whole) break;
        }
        if (!any && kept.empty()) return false;
        reader_.lines().set_line(line);
        frame = reader_.read_frame(kept);
        frame.frame = passed_ - 1;
        return true;
    }

    std::optional<std::uint64_t> count_rest() override {
        if (!find()) return 0;
        if (found_ == FrameText::Found::stray) (void)reader_.read_frame(text_.text());  // throws
        if (found_ != FrameText::Found::whole) return std::nullopt;
        const auto rest = text_.count_rest();
        return rest ? std::optional(*rest + 1) : std::nullopt;
    }

    [[nodiscard]] double fraction() const override { return source_->fraction(); }
    [[nodiscard]] const std::string& name() const override { return source_->name(); }

private:
    bool find() {
        found_ = text_.next();
        return found_ != FrameText::Found::none;
    }
    void end(Input& frame) {
        frame.frame = passed_++;
        lines_before_ += text_.lines();
        reader_.lines().set_line(lines_before_);
    }

    std::unique_ptr<TextSource> source_;
    FrameText text_;
    FrameText::Found found_ = FrameText::Found::none;
    Reader reader_;
    std::size_t lines_before_ = 0;
};

}  // namespace clvotess

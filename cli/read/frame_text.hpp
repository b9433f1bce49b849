// Finds the frames of a text: where each begins and ends, without reading its numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "files/text_source.hpp"

namespace clvotess {

enum class FrameKind { xyz, lammps_dump };

class FrameText {
public:
    enum class Found {
        none,    // the end of the text
        whole,   // a frame
        broken,  // a frame that ends too early, or has no readable count; the reader reports it
        stray    // a line that does not begin a frame
    };

    // source: must outlive this. head: text that was read from it before.
    FrameText(TextSource& source, FrameKind kind, std::string head = {})
        : source_(source), kind_(kind), buffer_(std::move(head)) {}

    // Finds the next frame. Views of the previous one become invalid.
    Found next();
    // Returns the text of the frame, in whole lines. It begins where the previous one ends.
    [[nodiscard]] std::string_view text() const noexcept {
        return std::string_view(buffer_).substr(begin_, end_ - begin_);
    }
    // Returns the number of lines in the frame.
    [[nodiscard]] std::size_t lines() const noexcept { return lines_; }
    // Returns how many whole frames follow; nothing if their text is long, or not one of frames only.
    [[nodiscard]] std::optional<std::uint64_t> count_rest();

private:
    bool read_more();
    // Takes a line. Returns false at the end, and for a line that is too long, which sets too_long_.
    bool next_line(std::string_view& line);
    bool next_filled(std::string_view& line);
    [[nodiscard]] Found next_xyz();
    [[nodiscard]] Found next_dump();
    // Reserves memory for `rows` rows of about this length.
    void reserve(std::uint64_t rows, std::size_t length);

    TextSource& source_;
    FrameKind kind_;
    std::string buffer_;
    std::size_t begin_ = 0, end_ = 0, lines_ = 0;  // of the frame; end_ moves on while it is searched
    bool begun_ = false, more_ = true, too_long_ = false;
};

}  // namespace clvotess

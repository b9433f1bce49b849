#include "read/frame_text.hpp"

#include <algorithm>
#include <cstring>

#include "files/limits.hpp"
#include "files/line_reader.hpp"
#include "files/numbers.hpp"

namespace clvotess {
namespace {

std::optional<std::uint64_t> lone_count(std::string_view line) {
    const auto begin = line.find_first_not_of(blanks);
    if (begin == std::string_view::npos) return std::nullopt;
    return read_uint64(line.substr(begin, line.find_last_not_of(blanks) + 1 - begin));
}

bool is_blank_line(std::string_view line) {
    const bool begins = !line.empty() && line[0] > ' ';  // most rows do
    return !begins && line.find_first_not_of(blanks) == std::string_view::npos;
}

}  // namespace

bool FrameText::read_more() {
    if (!more_) return false;
    buffer_.erase(0, begin_);
    end_ -= begin_;
    begin_ = 0;
    const std::size_t before = buffer_.size();
    more_ = source_.append(buffer_);
    return more_ || buffer_.size() > before;
}

bool FrameText::next_line(std::string_view& line) {
    std::size_t seen = end_;
    for (;;) {
        const char* const from = buffer_.data() + seen;
        const auto* const end = static_cast<const char*>(std::memchr(from, '\n', buffer_.size() - seen));
        const std::size_t length = (end ? static_cast<std::size_t>(end - buffer_.data()) : buffer_.size()) - end_;
        if (length > max_line) {
            end_ = buffer_.size();
            too_long_ = true;
            return false;
        }
        if (end || (!more_ && length > 0)) {
            line = std::string_view(buffer_).substr(end_, length);
            end_ += length + (end ? 1 : 0);
            ++lines_;
            return true;
        }
        const std::size_t known = buffer_.size() - end_;
        if (!read_more() && !more_ && buffer_.size() == end_) return false;
        seen = end_ + known;
    }
}

bool FrameText::next_filled(std::string_view& line) {
    while (next_line(line))
        if (!is_blank_line(line)) return true;
    return false;
}

void FrameText::reserve(std::uint64_t rows, std::size_t length) {
    const auto rest = source_.rest();
    if (!rest) return;
    const std::uint64_t room = std::min(*rest, rows > *rest ? *rest : 2 * rows * (length + 1));  // rows may be longer
    buffer_.reserve(buffer_.size() + static_cast<std::size_t>(room));
}

FrameText::Found FrameText::next() {
    begin_ = end_;
    lines_ = 0;
    if (!begun_) {
        while (buffer_.size() < 3 && read_more()) {
        }
        if (buffer_.starts_with("\xef\xbb\xbf")) buffer_.erase(0, 3);
        begun_ = true;
    }
    const Found found = kind_ == FrameKind::xyz ? next_xyz() : next_dump();
    return too_long_ ? Found::broken : found;
}

FrameText::Found FrameText::next_xyz() {
    std::string_view line;
    if (!next_filled(line)) return Found::none;
    const auto count = lone_count(line);
    if (!count) return Found::stray;
    if (!next_line(line)) return *count == 0 ? Found::whole : Found::broken;
    for (std::uint64_t i = 0; i < *count; ++i) {
        if (!next_filled(line)) return Found::broken;
        if (i == 0) reserve(*count, line.size());
    }
    return Found::whole;
}

FrameText::Found FrameText::next_dump() {
    std::string_view line;
    if (!next_filled(line)) return Found::none;
    if (!line.starts_with("ITEM:") && line.substr(line.find_first_not_of(blanks)).substr(0, 5) != "ITEM:")
        return Found::stray;
    std::optional<std::uint64_t> count;
    do {
        const auto item = std::min(line.find("ITEM:"), line.size());
        const std::string_view head = line.substr(std::min(item + 5, line.size()));
        const std::string_view name = head.substr(std::min(head.find_first_not_of(' '), head.size()));
        if (item == line.size()) continue;  // a value
        if (name.starts_with("NUMBER OF ATOMS")) {
            if (!next_line(line)) return Found::broken;
            count = lone_count(line);
            if (!count) return Found::broken;
        } else if (name.starts_with("ATOMS")) {
            if (!count) return Found::broken;
            for (std::uint64_t i = 0; i < *count; ++i) {
                if (!next_line(line)) return Found::broken;
                if (i == 0) reserve(*count, line.size());
            }
            return Found::whole;
        }
    } while (next_filled(line));
    return Found::broken;
}

std::optional<std::uint64_t> FrameText::count_rest() {
    constexpr std::uint64_t max_bytes = std::uint64_t{64} << 20;
    const auto rest = source_.rest();
    if (!rest || *rest > max_bytes) return std::nullopt;
    for (std::uint64_t count = 0;; ++count) {
        const Found found = next();
        if (found == Found::none) return count;
        if (found != Found::whole) return std::nullopt;
    }
}

}  // namespace clvotess

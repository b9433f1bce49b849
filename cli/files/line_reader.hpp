// Lines and words of a text, with line numbers for messages.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "failure.hpp"
#include "files/limits.hpp"
#include "files/numbers.hpp"
#include "interrupt.hpp"

namespace clvotess {

using Words = std::vector<std::string_view>;

inline constexpr std::string_view blanks = " \t\r\v\f";

[[nodiscard]] constexpr bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

// Returns the index of a name; nothing without it.
template <class Names>
[[nodiscard]] std::optional<std::size_t> find_name(const Names& names, std::string_view name) {
    const auto at = std::ranges::find(names, name);
    if (at == names.end()) return std::nullopt;
    return static_cast<std::size_t>(at - names.begin());
}

inline void split_words(std::string_view line, Words& words) {
    words.clear();
    const char *at = line.data(), *const end = at + line.size();
    for (;;) {
        while (at != end && is_blank(*at)) ++at;
        if (at == end) return;
        const char* const begin = at;
        while (at != end && !is_blank(*at)) ++at;
        words.emplace_back(begin, static_cast<std::size_t>(at - begin));
    }
}

[[nodiscard]] std::string lower_case(std::string_view text);    // of ASCII
[[nodiscard]] std::string columns_text(std::size_t count);      // "1 column", "5 columns"
[[nodiscard]] std::string not_a_number(std::string_view word);  // the message for a word that is not a number

class LineReader {
public:
    LineReader(std::string_view text, std::string name) : name_(std::move(name)) { go_on(text); }

    // Continues with more text, which begins with a whole line. Skips the byte order mark of UTF-8 before the first
    // line.
    void go_on(std::string_view text) {
        rest_ = text;
        if (line_ == 0 && rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3);
    }

    // Takes the next line. Returns false at the end. Throws Failure for a line that is too long, and Interrupted soon
    // after a signal.
    [[nodiscard]] bool next(std::string_view& line) {
        if (rest_.empty()) return false;
        const std::string_view near = rest_.substr(0, max_line + 1);
        const auto end = std::min(near.find('\n'), near.size());
        constexpr std::size_t lines_in_a_round = 4096;
        if (++line_ % lines_in_a_round == 0) throw_if_interrupted();
        if (end > max_line) throw error("a line of more than " + std::to_string(max_line) + " bytes");
        line = rest_.substr(0, end);
        rest_.remove_prefix(std::min(end + 1, rest_.size()));
        return true;
    }
    // Takes the next line too and appends it to `line`, which was the last. Returns false at the end. Throws Failure
    // for lines that are too long together.
    [[nodiscard]] bool extend(std::string_view& line) {
        std::string_view more;
        if (!next(more)) return false;
        line = {line.data(), static_cast<std::size_t>(more.data() + more.size() - line.data())};
        if (line.size() > max_line) throw error("a row of more than " + std::to_string(max_line) + " bytes");
        return true;
    }
    // Returns to a line that was taken, and to its number.
    void go_back(std::string_view line, std::size_t number) {
        rest_ = {line.data(), static_cast<std::size_t>(rest_.data() + rest_.size() - line.data())};
        line_ = number - 1;
    }
    // Takes the next line that is not blank. Returns false at the end.
    [[nodiscard]] bool next_filled(std::string_view& line) {
        do {
            pass_line_ends();
            if (!next(line)) return false;
        } while (line.find_first_not_of(blanks) == std::string_view::npos);
        return true;
    }

    // Returns the next line. Throws Failure at the end.
    [[nodiscard]] std::string_view need(const std::string& what) {
        std::string_view line;
        if (!next(line)) throw error("the file ends where " + what + " is expected");
        return line;
    }

    [[nodiscard]] Failure error(const std::string& message) const { return bad_input(place() + ": " + message); }
    [[nodiscard]] std::string place() const { return name_ + ":" + std::to_string(line_); }

    [[nodiscard]] double number(std::string_view word) const {
        if (const auto value = read_double(word)) return *value;
        throw error(not_a_number(word));
    }
    // Returns the number of a column that the user requested.
    [[nodiscard]] double number(std::string_view word, std::string_view column) const {
        if (const auto value = read_double(word)) return *value;
        if (has_decimal_comma(word)) throw error(not_a_number(word));
        throw error(not_a_number(word) + ": the column " + in_quotes(column) + " has text where numbers are needed");
    }
    [[nodiscard]] std::int64_t whole(std::string_view word, const char* what) const {
        if (const auto value = read_int64(word)) return *value;
        if (has_decimal_comma(word)) throw error(not_a_number(word));
        throw error(in_quotes(word) + " is not a whole number, as " + what + " must be");
    }

    [[nodiscard]] std::string_view rest() const noexcept { return rest_; }
    // Skips `count` bytes, which hold `lines` line ends.
    void skip(std::size_t count, std::size_t lines) {
        rest_.remove_prefix(count);
        line_ += lines;
    }
    [[nodiscard]] std::size_t line() const noexcept { return line_; }  // number of the last line
    void set_line(std::size_t line) noexcept { line_ = line; }
    [[nodiscard]] const std::string& name() const noexcept { return name_; }

private:
    void pass_line_ends() {
        constexpr std::size_t piece = std::size_t{1} << 20;
        while (!rest_.empty() && rest_[0] == '\n') {
            const std::string_view near = rest_.substr(0, piece);
            const auto count = std::min(near.find_first_not_of('\n'), near.size());
            throw_if_interrupted();
            skip(count, count);
        }
    }

    std::string_view rest_;
    std::string name_;
    std::size_t line_ = 0;
};

// Returns whether `rows`, a count that a file announces, fits into the remaining bytes. This keeps a broken count from
// taking memory.
inline bool can_hold(std::size_t bytes, std::uint64_t rows, std::size_t bytes_each) {
    return rows <= bytes / std::max<std::size_t>(bytes_each, 1) + 1;
}

}  // namespace clvotess

// Errors of clvotess: one exception type, with an exit code and one line of text.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

namespace clvotess {

namespace exit_code {
inline constexpr int done = 0;
inline constexpr int runtime_failure = 1;      // disk full, out of memory, device lost
inline constexpr int bad_input = 2;            // bad usage or input: the user can correct it
inline constexpr int verification_failed = 3;  // --verify
inline constexpr int signal_base = 128;        // plus the signal number, as shells do
}  // namespace exit_code

class Failure : public std::runtime_error {
public:
    Failure(int code, const std::string& message) : std::runtime_error(message), code_(code) {}
    [[nodiscard]] int code() const noexcept { return code_; }

private:
    int code_;
};

// Returns a message as one line of bounded length without control bytes, which names in files may hold.
[[nodiscard]] inline std::string one_line(std::string message) {
    constexpr std::size_t longest = 2000;
    std::ranges::replace_if(
        message, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
    return message.size() <= longest ? message : message.substr(0, longest) + "...";
}

[[nodiscard]] inline Failure bad_input(const std::string& message) {
    return {exit_code::bad_input, message};
}
[[nodiscard]] inline Failure runtime_failure(const std::string& message) {
    return {exit_code::runtime_failure, message};
}

// Returns the number of bytes of the UTF-8 character at the begin of a text; 0 if there is none.
[[nodiscard]] std::size_t utf8_length(std::string_view text);
[[nodiscard]] bool is_utf8(std::string_view text);

// Returns a user's text for a message: in quotes, cut when long, with control bytes and those that are not UTF-8 as
// \xNN.
[[nodiscard]] std::string in_quotes(std::string_view text);

// Appends a name to a list with blanks between the names.
inline void add_name(std::string& list, std::string_view name) {
    if (!list.empty()) list += ' ';
    list += name;
}

}  // namespace clvotess

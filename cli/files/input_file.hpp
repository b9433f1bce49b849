// A file or stdin, read front to back into the caller's memory. It is not mapped: a file that shrinks would end the
// program by SIGBUS, and bytes could change under a parser.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/system.hpp"

namespace clvotess {

class InputFile {
public:
    explicit InputFile(const std::string& path);  // "-" is stdin. Throws Failure
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    // Reads the next bytes and returns their number, less than `count` only at the end. Throws Interrupted soon after a
    // signal, and Failure when the file ends before its size at opening.
    std::size_t read(char* to, std::size_t count);
    // Appends the next bytes, up to a number. Returns false at the end.
    bool append(std::string& to, std::size_t count);
    // Skips bytes of a regular file.
    void skip(std::uint64_t count);

    [[nodiscard]] bool is_regular() const noexcept { return regular_size_.has_value(); }
    [[nodiscard]] bool is_device() const { return file_.is_device(); }
    // At opening; 0 unless the file is regular.
    [[nodiscard]] std::uint64_t size() const noexcept { return regular_size_.value_or(0); }
    [[nodiscard]] const std::string& name() const noexcept { return name_; }

private:
    std::string name_;  // for messages
    votess::system::File file_;
    std::optional<std::uint64_t> regular_size_;
    std::uint64_t done_ = 0;
};

// Returns all bytes of a file. Refuses a device, which may have no end.
[[nodiscard]] std::string read_whole(const std::string& path);

// Throws Failure when the last line of a text is too long. `name` is for the message.
void check_last_line(std::string_view text, const std::string& name);

}  // namespace clvotess

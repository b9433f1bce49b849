// A file that appears whole or not at all, also after a loss of power: written without a name, brought to the disk,
// then named. A run that is killed leaves nothing. It leaves a file `.clvotess-*.tmp` in two cases: where the system or
// the file system has no unnamed files (O_TMPFILE), and between the two calls that replace an old file (linkat,
// rename).
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "failure.hpp"

namespace clvotess {

// An existing file that is neither regular nor a folder (device, pipe): there is nothing to rename, it is written to
// directly.
[[nodiscard]] bool is_special_file(const std::string& path);

// Throws Failure when `path` cannot become a file: no such folder, a folder itself, no permission.
void check_writable(const std::string& path);

// Brings the bytes of a file to the disk. Throws Failure.
void sync_file(const std::string& path);

// Equal for two names of the same file, existing or not.
[[nodiscard]] std::string identity_of(const std::string& path);

class OutputFile {
public:
    // named: other processes can open it before it is published, but a run that is killed leaves it.
    enum class Temporary { unnamed, named };

    explicit OutputFile(const std::string& path, Temporary temporary = Temporary::unnamed);  // "-" is stdout
    OutputFile(OutputFile&& other) noexcept;
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    OutputFile& operator=(OutputFile&&) = delete;
    ~OutputFile();  // removes what was not published

    [[nodiscard]] std::string description() const;  // for messages
    // Unbuffered: give it large pieces. Throws Failure on a write error, Interrupted on a signal.
    void write(std::string_view bytes);
    // Returns a path that opens the temporary file, for libraries that write by name. An unnamed file has one in this
    // process only. Throws Failure when the target is a device or a pipe.
    [[nodiscard]] std::string path_for_library() const;
    // What write() throws; 0 when the reason is not known.
    [[nodiscard]] Failure write_failure(int error) const;
    void finish();   // brings all bytes to the disk; no write after it
    void publish();  // gives the file its name, and brings that to the disk

private:
    void open_temporary(Temporary temporary);
    void close_quietly() noexcept;

    std::string name_;       // as the user gave it, for messages
    std::string target_;     // links resolved; empty when written to directly
    std::string temporary_;  // of a file that is not published; empty when it has no name
    int descriptor_ = -1;
};

// A buffer of fixed size in front of an OutputFile, for text and for binary numbers.
class OutputBuffer {
public:
    explicit OutputBuffer(OutputFile& file) : file_(file), bytes_(capacity, '\0') {}

    void put(std::string_view text) {
        if (text.empty()) return;
        if (text.size() > capacity - used_) flush();
        if (text.size() > capacity) return file_.write(text);
        std::memcpy(bytes_.data() + used_, text.data(), text.size());
        used_ += text.size();
    }

    void put(char c) {
        make_room();
        bytes_[used_++] = c;
    }

    // Numbers that are no whole ones get at most so many digits, as %g prints them; else as few as read back the same.
    void set_digits(int digits) { digits_ = digits; }

    // Writes a number as text.
    template <typename Number>
    void put_number(Number value) {
        make_room();
        if constexpr (std::is_floating_point_v<Number>) {
            if (std::isnan(value)) return put(std::string_view("nan"));  // never -nan
        }
        char* const begin = bytes_.data() + used_;
        char* end = nullptr;
        if constexpr (std::is_floating_point_v<Number>) {
            end = digits_ > 0
                      ? std::to_chars(begin, begin + longest_number, value, std::chars_format::general, digits_).ptr
                      : std::to_chars(begin, begin + longest_number, value).ptr;
        } else {
            end = std::to_chars(begin, begin + longest_number, value).ptr;
        }
        used_ += static_cast<std::size_t>(end - begin);
    }

    void put_three(double x, double y, double z, char between = ' ') {
        put_number(x);
        put(between);
        put_number(y);
        put(between);
        put_number(z);
    }

    // Writes a value as it lies in memory.
    template <typename Number>
    void put_binary(Number value) {
        make_room();
        std::memcpy(bytes_.data() + used_, &value, sizeof value);
        used_ += sizeof value;
    }

    void flush() {
        file_.write(std::string_view(bytes_.data(), used_));
        used_ = 0;
    }

private:
    static constexpr std::size_t capacity = std::size_t{1} << 20;
    static constexpr std::size_t longest_number = 32;

    void make_room() {
        if (capacity - used_ < longest_number) flush();
    }

    OutputFile& file_;
    std::string bytes_;
    std::size_t used_ = 0;
    int digits_ = 0;
};

}  // namespace clvotess

// A file that appears whole or not at all, also after a power failure. It is written without a name, synced, then
// named. A killed run leaves a file `.clvotess-*.tmp` in two cases only: where unnamed files (O_TMPFILE) are not
// supported, and between the two calls that replace an old file (linkat, rename).
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/system.hpp"
#include "failure.hpp"

namespace clvotess {

// Returns the memory of an array of numbers.
std::string_view bytes_of(const auto& numbers) {
    return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(numbers[0])};
}

// Returns whether a file exists that is neither regular nor a folder, such as a device or pipe. It is written directly.
[[nodiscard]] bool is_special_file(const std::string& path);

// Throws Failure when `path` cannot become a file: its folder is missing, it is a folder, or permission is missing.
void check_writable(const std::string& path);

// Syncs a file to the disk. Throws Failure.
void sync_file(const std::string& path);

// Returns a name that is equal for all names of a file, which need not exist.
[[nodiscard]] std::string identity_of(const std::string& path);

class OutputFile {
public:
    // named: other processes can open the file before it is published, but a killed run leaves it.
    enum class Temporary { unnamed, named };

    explicit OutputFile(const std::string& path, Temporary temporary = Temporary::unnamed);  // "-" is stdout
    OutputFile(OutputFile&& other) noexcept;
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    OutputFile& operator=(OutputFile&&) = delete;
    ~OutputFile();  // removes the file and the folders that it made, unless it was published

    [[nodiscard]] std::string description() const;  // for messages
    // Unbuffered: pass large pieces. Throws Failure on a write error, Interrupted after a signal.
    void write(std::string_view bytes);
    // Returns another file, in a folder within the folder of this one, which it makes. It is finished and published
    // with this file. Calls for one name follow each other. Throws Failure for a device or a pipe.
    [[nodiscard]] OutputFile& beside(const std::string& name);
    // Returns a path to the temporary file, for libraries that write by name. Only this process can use the path of an
    // unnamed file. Throws Failure for a device or a pipe.
    [[nodiscard]] std::string path_for_library() const;
    // Returns the exception that write() throws. error: errno, or 0 if unknown.
    [[nodiscard]] Failure write_failure(int error) const;
    void finish();   // syncs the file; no write may follow
    void publish();  // gives the file its name, and syncs the folder

private:
    void require_regular() const;
    void open_temporary(Temporary temporary);
    void make_folders(const std::filesystem::path& folder, std::error_code& problem);

    std::string name_;       // as given by the user, for messages
    std::string target_;     // links resolved; empty when written to directly
    std::string temporary_;  // name until publish(); may be empty
    votess::system::File file_;
    std::vector<OutputFile> beside_;
    std::vector<std::filesystem::path> made_;  // folders, each after that which it is in; removed with the file
};

// Text and binary numbers for a file.
class OutputBuffer {
public:
    void put(std::string_view text) {
        make_room(text.size());
        std::memcpy(bytes_.data() + used_, text.data(), text.size());
        used_ += text.size();
    }

    void put(char c) {
        make_room(1);
        bytes_[used_++] = c;
    }

    // Limits floating-point numbers to so many digits, as %g does. 0, the default: the shortest text that reads back
    // the same.
    void set_digits(int digits) { digits_ = digits; }

    // Writes a number as text.
    template <typename Number>
    void put_number(Number value) {
        make_room(longest_number);
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

    void put_vector(std::span<const double> vector, char between = ' ') {
        for (std::size_t k = 0; k < vector.size(); ++k) {
            if (k > 0) put(between);
            put_number(vector[k]);
        }
    }

    // Writes the bytes of a value.
    template <typename Number>
    void put_binary(Number value) {
        make_room(sizeof value);
        std::memcpy(bytes_.data() + used_, &value, sizeof value);
        used_ += sizeof value;
    }

    [[nodiscard]] std::string_view bytes() const noexcept { return std::string_view(bytes_).substr(0, used_); }
    void clear() noexcept { used_ = 0; }

private:
    static constexpr std::size_t longest_number = 32;

    void make_room(std::size_t count) {
        if (bytes_.size() - used_ < count) bytes_.resize(2 * bytes_.size() + count);
    }

    std::string bytes_;
    std::size_t used_ = 0;
    int digits_ = 0;
};

}  // namespace clvotess

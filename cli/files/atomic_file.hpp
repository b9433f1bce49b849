// A file that appears whole or not at all: written under a temporary name in the same folder, then renamed.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace clvotess {

// An existing file that is neither regular nor a folder (device, pipe): there is nothing to rename, it is written to
// directly.
[[nodiscard]] bool is_special_file(const std::string& path);

// Throws Failure when `path` cannot become a file: no such folder, a folder itself, no permission.
void check_writable(const std::string& path);

// Equal for two names of the same file, existing or not.
[[nodiscard]] std::string identity_of(const std::string& path);

class Failure;

class OutputFile {
public:
    explicit OutputFile(const std::string& path);  // "-" is stdout
    OutputFile(OutputFile&& other) noexcept;
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    OutputFile& operator=(OutputFile&&) = delete;
    ~OutputFile();  // removes what was not published

    // Unbuffered: give it large pieces. Throws Failure on a write error, Interrupted on a signal.
    void write(std::string_view bytes);
    // For libraries that write to a file by its name, instead of write(): that of the temporary file. Throws Failure
    // when there is none, because the target is a device or a pipe.
    [[nodiscard]] const std::string& path_for_library() const;
    // What write() throws; 0 when the reason is not known.
    [[nodiscard]] Failure write_failure(int error) const;
    void finish();   // all bytes are with the system; no write after it
    void publish();  // the file appears under its name

private:
    [[nodiscard]] std::string description() const;
    void close_quietly() noexcept;

    std::string name_;       // as the user gave it, for messages
    std::string target_;     // links resolved
    std::string temporary_;  // empty when written to directly, or published
    int descriptor_ = -1;
};

}  // namespace clvotess

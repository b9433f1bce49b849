// A file that appears whole or not at all, also after a loss of power: written without a name, brought to the disk,
// then named. A run that is killed leaves nothing. It leaves a file `.clvotess-*.tmp` in two cases: where the system or
// the file system has no unnamed files (O_TMPFILE), and between the two calls that replace an old file (linkat,
// rename).
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

// Brings the bytes of a file to the disk. Throws Failure.
void sync_file(const std::string& path);

// Equal for two names of the same file, existing or not.
[[nodiscard]] std::string identity_of(const std::string& path);

class Failure;

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

}  // namespace clvotess

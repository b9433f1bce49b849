// All that differs between systems: files, shared libraries, signals, memory. No other source file asks which system
// it is on, except votess/export.hpp. clvotess compiles system.cpp too.
//
// Text is UTF-8. Functions for files set errno when they fail.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace votess::system {

[[nodiscard]] std::filesystem::path path_of(std::string_view text);
[[nodiscard]] std::string text_of(const std::filesystem::path& path);

// An open file, binary. Counts of read() and write() are as in POSIX: bytes done, -1 for an error.
class File {
public:
    File() = default;  // none
    File(File&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    File& operator=(File&& other) noexcept {
        std::swap(descriptor_, other.descriptor_);
        return *this;
    }
    ~File() { (void)close(); }

    [[nodiscard]] static File standard_input();
    [[nodiscard]] static File standard_output();
    // These return no file when they fail.
    [[nodiscard]] static File open_to_read(const std::filesystem::path& path);
    [[nodiscard]] static File open_to_write(const std::filesystem::path& path);
    [[nodiscard]] static File create(const std::filesystem::path& path);  // EEXIST: the name is taken
    // A file that ends with the process.
    [[nodiscard]] static File temporary(const std::filesystem::path& folder);
    // A file for give_name(), which ends with the process before that. Some systems have none.
    [[nodiscard]] static File nameless(const std::filesystem::path& folder);

    [[nodiscard]] bool is_open() const noexcept { return descriptor_ >= 0; }
    [[nodiscard]] bool is_standard() const noexcept { return is_open() && descriptor_ <= 2; }
    [[nodiscard]] std::optional<std::uint64_t> regular_size() const;  // nothing for a device or a pipe
    [[nodiscard]] bool is_device() const;                             // one of characters, as a terminal or /dev/zero

    [[nodiscard]] std::ptrdiff_t read(std::span<std::byte> to);
    [[nodiscard]] std::ptrdiff_t write(std::span<const std::byte> bytes);
    // From any thread. Not mixed with read() and write().
    [[nodiscard]] std::ptrdiff_t read_at(std::uint64_t position, std::span<std::byte> to) const;
    [[nodiscard]] std::ptrdiff_t write_at(std::uint64_t position, std::span<const std::byte> bytes);
    [[nodiscard]] bool skip(std::uint64_t count);
    [[nodiscard]] bool rewind();
    // Returns 0 or an error number. A file system that cannot sync is not an error.
    [[nodiscard]] int sync() const;
    // Leaves standard streams open. Returns false on an error, for some devices that of a write.
    bool close() noexcept;

    // Returns a path of a nameless file, for this process; gives it a name in its file system (EEXIST: it is taken).
    [[nodiscard]] std::filesystem::path path() const;
    [[nodiscard]] bool give_name(const std::filesystem::path& name) const;

private:
    explicit File(int descriptor) : descriptor_(descriptor) {}
    int descriptor_ = -1;
};

// Returns 0 or an error number. A folder without read permission is not synced.
[[nodiscard]] int sync_folder(const std::filesystem::path& folder);
// Whether a file may be written, or a folder may get new files.
[[nodiscard]] bool may_write(const std::filesystem::path& path);
// Returns the folder of temporary files: TMPDIR or /tmp, on Windows the user's.
[[nodiscard]] std::filesystem::path temporary_folder();

// A shared library. It is never unmapped: Vulkan's drivers leave threads and thread-local destructors behind.
class SharedLibrary {
public:
    SharedLibrary() = default;  // none
    // Returns none when it fails, with the reason in `failure`.
    [[nodiscard]] static SharedLibrary open(const std::filesystem::path& path, std::string& failure);
    SharedLibrary(SharedLibrary&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    SharedLibrary& operator=(SharedLibrary&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~SharedLibrary();

    [[nodiscard]] bool is_open() const noexcept { return handle_ != nullptr; }
    [[nodiscard]] void* symbol(const char* name) const;  // null if absent

private:
    explicit SharedLibrary(void* handle) : handle_(handle) {}
    void* handle_ = nullptr;
};
// Names of Vulkan's loader, or of the driver that serves as one, in the order to try.
[[nodiscard]] std::vector<std::string> vulkan_loaders();

// During its lifetime SIGINT, SIGTERM and SIGHUP set a flag. A second signal ends the program at once.
class SignalGuard {
public:
    SignalGuard();
    ~SignalGuard();
    SignalGuard(const SignalGuard&) = delete;
    SignalGuard& operator=(const SignalGuard&) = delete;

private:
    struct Old;
    std::unique_ptr<Old> old_;
};
// Returns the received signal, or 0.
[[nodiscard]] int received_signal() noexcept;
// The signal of a pipe whose reader closed it. A write fails instead after begin_program().
inline constexpr int closed_pipe = 13;

// Prepares the standard streams. A closed one gets an empty file: otherwise the first file opened would get its number,
// and messages would go into it. Returns the arguments of main() in UTF-8.
[[nodiscard]] std::vector<std::string> begin_program(int argc, const char* const* argv);
[[nodiscard]] bool stderr_is_terminal();
[[nodiscard]] std::filesystem::path program_path();

[[nodiscard]] std::int64_t process_id();
// In bytes, resident; 0 if unknown.
[[nodiscard]] std::uint64_t peak_memory();
[[nodiscard]] std::uint64_t resident_memory();
// Returns freed memory to the system. Otherwise memory of one size is kept while another size is allocated.
void give_back_memory();

inline constexpr std::size_t huge_page = std::size_t{2} << 20;
inline constexpr std::size_t min_released = std::size_t{64} << 20;  // less is not worth the page faults

// Hints for pages, ignored by some systems. Makes pages present, which clears new ones.
void touch_pages(void* begin, std::size_t bytes);
// Returns pages to the system and keeps the addresses. The contents are lost.
void release_pages(void* begin, std::size_t bytes);
void prefer_huge_pages(void* begin, std::size_t bytes);
// Moves whole huge pages to the addresses `to`, whose own pages are lost. The addresses `from` get new pages when they
// are used. Returns false if the system does not move them; then all contents are undefined.
[[nodiscard]] bool move_pages(void* from, void* to, std::size_t bytes);

// The process that made an object. A child made by fork() has its memory but not its threads and devices, and may
// neither use nor end them.
class HomeProcess {
public:
    [[nodiscard]] bool is_this() const { return id_ == process_id(); }

private:
    std::int64_t id_ = process_id();
};

}  // namespace votess::system

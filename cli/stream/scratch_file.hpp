// A temporary file of bytes that are written, then read, front to back. It has no name, so it is gone with the process.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clvotess {

class ScratchFile {
public:
    explicit ScratchFile(const std::string& folder);
    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;
    ~ScratchFile();

    void write(std::string_view bytes);
    void rewind();
    void read(void* to, std::size_t bytes);
    // Adds to a double that is written already; its place is in bytes.
    void add_to(std::uint64_t place, double value);
    [[nodiscard]] std::uint64_t size() const noexcept { return size_; }

private:
    std::string folder_;
    int descriptor_ = -1;
    std::uint64_t size_ = 0;
};

}  // namespace clvotess

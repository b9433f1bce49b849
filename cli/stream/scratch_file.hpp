// A temporary file, written and then read front to back. It has no name, so it vanishes with the process.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/system.hpp"

namespace clvotess {

class ScratchFile {
public:
    explicit ScratchFile(const std::string& folder);
    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;

    void write(std::string_view bytes);
    void rewind();
    void read(void* to, std::size_t bytes);
    // Adds a value to a double that is already written. place: its offset in bytes.
    void add_to(std::uint64_t place, double value);
    [[nodiscard]] std::uint64_t size() const noexcept { return size_; }

private:
    std::string folder_;
    votess::system::File file_;
    std::uint64_t size_ = 0;
};

}  // namespace clvotess

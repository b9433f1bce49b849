// The bytes of a file, read-only. A regular file is mapped, so that its pages can be given back while it is read;
// anything else (a pipe, stdin) is read into memory.
#pragma once

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace clvotess {

class MappedFile {
public:
    explicit MappedFile(const std::string& path);  // "-" is stdin. Throws Failure
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;
    ~MappedFile();

    [[nodiscard]] std::string_view bytes() const noexcept { return bytes_; }

private:
    void* mapping_ = nullptr;
    std::string copy_;
    std::string_view bytes_;
};

}  // namespace clvotess

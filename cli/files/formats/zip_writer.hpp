// Writes an archive of uncompressed members, front to back, with zip64 where a size or offset needs it.
// Format: PKWARE APPNOTE.TXT 6.3, sections 4.3 and 4.5.3.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace clvotess {

class OutputFile;

class ZipWriter {
public:
    // largest32: sizes and offsets from this value on use zip64. Tests set a smaller value than the format's limit.
    explicit ZipWriter(OutputFile& file, std::uint64_t largest32 = 0xffffffff) : file_(file), largest32_(largest32) {}

    // Adds a member, whose bytes are the parts in order.
    void add(const std::string& name, std::span<const std::string_view> parts);
    void finish();

private:
    struct Member {
        std::string name;
        std::uint32_t crc = 0;
        std::uint64_t size = 0;
        std::uint64_t offset = 0;
    };

    void write(std::string_view bytes);
    [[nodiscard]] bool needs_zip64(std::uint64_t value) const { return value >= largest32_; }

    OutputFile& file_;
    std::uint64_t largest32_;
    std::uint64_t position_ = 0;
    std::vector<Member> members_;
};

}  // namespace clvotess

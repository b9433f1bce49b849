// The members of a zip archive: stored or deflated, with zip64.
// Format: PKWARE APPNOTE.TXT 6.3, sections 4.3 and 4.5.3; RFC 1951 for deflate.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "files/formats/npy_array.hpp"

namespace clvotess {

struct ZipMember {
    std::string name;
    bool deflated = false;
    std::uint32_t crc = 0;
    std::uint64_t size = 0;   // unpacked, bytes
    std::string_view packed;  // bytes in the archive
};

// Returns the members of an archive, whose bytes must outlive them. Throws Failure. name: for messages.
[[nodiscard]] std::vector<ZipMember> list_members(std::string_view bytes, const std::string& name);

// Returns a reader of the contents of a member, front to back. It throws Failure at the end for a wrong checksum.
[[nodiscard]] ByteSource open_member(const ZipMember& member, const std::string& name);

}  // namespace clvotess

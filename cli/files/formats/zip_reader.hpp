// The members of a zip archive: stored or deflated, zip64 where it occurs.
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
    std::uint64_t size = 0;   // of what it holds
    std::string_view packed;  // as it lies in the archive
};

// bytes: the whole archive, which must outlive the members. Throws Failure; `name` is for messages.
[[nodiscard]] std::vector<ZipMember> list_members(std::string_view bytes, const std::string& name);

// What a member holds, front to back. The last bytes are given only when the checksum is right.
[[nodiscard]] ByteSource open_member(const ZipMember& member, const std::string& name);

}  // namespace clvotess

#include "files/formats/zip_reader.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "failure.hpp"
#include "files/binary_numbers.hpp"
#include "files/inflate.hpp"
#include "files/limits.hpp"
#include "interrupt.hpp"

namespace clvotess {
namespace {

constexpr std::uint64_t see_zip64 = 0xffffffff;
constexpr std::uint64_t best_ratio = 1032;  // of deflate

// The little-endian fields of a record that begins at `at`.
class Fields {
public:
    Fields(std::string_view bytes, std::uint64_t at, std::uint64_t size, const std::string& name) : name_(name) {
        if (at > bytes.size() || size > bytes.size() - at) throw broken();
        bytes_ = bytes.substr(at, size);
    }
    [[nodiscard]] std::uint64_t u16(std::size_t at) const {
        return load_number<std::uint16_t>(bytes_.data() + at, false);
    }
    [[nodiscard]] std::uint64_t u32(std::size_t at) const {
        return load_number<std::uint32_t>(bytes_.data() + at, false);
    }
    [[nodiscard]] std::uint64_t u64(std::size_t at) const {
        return load_number<std::uint64_t>(bytes_.data() + at, false);
    }
    [[nodiscard]] std::string_view text(std::size_t at, std::size_t size) const { return bytes_.substr(at, size); }
    [[nodiscard]] Failure broken() const { return bad_input(name_ + ": the archive is damaged or ends too early"); }

private:
    std::string_view bytes_;
    const std::string& name_;
};

struct Directory {
    std::uint64_t begin = 0, count = 0;
};

Directory find_directory(std::string_view bytes, const std::string& name) {
    constexpr std::size_t end_size = 22, longest_comment = 65535;
    if (!bytes.starts_with("PK")) throw bad_input(name + ": not a zip archive, as an .npz file is");
    const std::size_t tail = std::min(bytes.size(), end_size + longest_comment);
    const auto at = bytes.substr(bytes.size() - tail).rfind("PK\x05\x06");
    if (at == std::string_view::npos) throw bad_input(name + ": the archive is damaged or ends too early");
    const std::uint64_t end = bytes.size() - tail + at;
    const Fields record(bytes, end, end_size, name);
    Directory directory{record.u32(16), record.u16(10)};
    constexpr std::size_t locator_size = 20;
    if (end < locator_size || bytes.substr(end - locator_size, 4) != "PK\x06\x07") return directory;
    const Fields locator(bytes, end - locator_size, locator_size, name);
    const Fields record64(bytes, locator.u64(8), 56, name);
    if (record64.text(0, 4) != "PK\x06\x06") throw record64.broken();
    return {record64.u64(48), record64.u64(32)};
}

// Reads size, packed size and offset of an entry. They are in its zip64 field where they exceed 32 bits.
void take_zip64(const Fields& extra, std::size_t extra_size, std::array<std::uint64_t, 3>& values) {
    for (std::size_t at = 0; at + 4 <= extra_size;) {
        const std::size_t id = extra.u16(at), size = extra.u16(at + 2);
        at += 4;
        if (size > extra_size - at) throw extra.broken();
        if (id == 1) {
            std::size_t used = 0;
            for (std::uint64_t& value : values) {
                if (value != see_zip64) continue;
                if (used + 8 > size) throw extra.broken();
                value = extra.u64(at + used);
                used += 8;
            }
            return;
        }
        at += size;
    }
}

// Throws Failure for members that share bytes, which would let a small archive unpack to much. A member is its header
// and its data.
void check_apart(std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges, const std::string& name) {
    std::ranges::sort(ranges);
    for (std::size_t k = 1; k < ranges.size(); ++k) {
        if (ranges[k].first < ranges[k - 1].second)
            throw bad_input(name + ": the archive is damaged: members overlap each other");
    }
}

}  // namespace

std::vector<ZipMember> list_members(std::string_view bytes, const std::string& name) {
    constexpr std::size_t entry_size = 46, header_size = 30;
    const Directory directory = find_directory(bytes, name);
    if (directory.count > max_arrays) {
        throw bad_input(name + ": " + std::to_string(directory.count) + " members, more than the " +
                        std::to_string(max_arrays) + " that are read");
    }
    std::vector<ZipMember> members;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
    std::uint64_t at = directory.begin, unpacked = 0;
    for (std::uint64_t i = 0; i < directory.count; ++i) {
        const Fields entry(bytes, at, entry_size, name);
        if (entry.text(0, 4) != "PK\x01\x02") throw entry.broken();
        const std::size_t name_size = entry.u16(28), extra_size = entry.u16(30), comment_size = entry.u16(32);
        const Fields tail(bytes, at + entry_size, name_size + extra_size, name);
        std::array<std::uint64_t, 3> values{entry.u32(24), entry.u32(20), entry.u32(42)};
        take_zip64(Fields(bytes, at + entry_size + name_size, extra_size, name), extra_size, values);
        const auto [size, packed_size, offset] = values;
        ZipMember member{.name = std::string(tail.text(0, name_size)),
                         .deflated = entry.u16(10) == 8,
                         .crc = static_cast<std::uint32_t>(entry.u32(16)),
                         .size = size,
                         .packed = {}};
        if ((entry.u16(8) & 1) != 0 || (entry.u16(10) != 0 && entry.u16(10) != 8)) {
            throw bad_input(name + ": member " + in_quotes(member.name) +
                            " is encrypted or packed by another method than deflate");
        }
        const Fields header(bytes, offset, header_size, name);
        if (header.text(0, 4) != "PK\x03\x04") throw header.broken();
        const std::uint64_t data = offset + header_size + header.u16(26) + header.u16(28);
        if (data > bytes.size() || packed_size > bytes.size() - data) throw header.broken();
        member.packed = bytes.substr(data, packed_size);
        const bool possible = member.deflated ? size / best_ratio <= packed_size : size == packed_size;
        if (!possible) throw header.broken();
        unpacked += size;
        check_unpacked(bytes.size(), unpacked, name);
        ranges.emplace_back(offset, data + packed_size);
        members.push_back(std::move(member));
        at += entry_size + name_size + extra_size + comment_size;
    }
    ranges.emplace_back(directory.begin, at);
    check_apart(std::move(ranges), name);
    return members;
}

ByteSource open_member(const ZipMember& member, const std::string& name) {
    struct State {
        std::string_view stored;
        std::unique_ptr<Inflater> inflater;
        uLong crc = crc32_z(0, nullptr, 0);
        std::uint64_t left = 0;
    };
    const auto state = std::make_shared<State>();
    state->left = member.size;
    state->stored = member.packed;
    if (member.deflated) state->inflater = std::make_unique<Inflater>(member.packed, Inflater::Frame::none);
    const auto read = [state, expected = member.crc, name](void* to, std::uint64_t count) {
        const Failure damaged = bad_input(name + ": the archive is damaged: the checksum is not that of the member");
        if (count == 0) return;
        if (count > state->left) throw bad_input(name + ": the member ends too early");
        constexpr std::uint64_t piece = std::uint64_t{1} << 22;
        auto* at = static_cast<char*>(to);
        for (std::uint64_t left = count; left > 0;) {
            throw_if_interrupted();
            const std::uint64_t some = std::min(left, piece);
            if (state->inflater) {
                if (state->inflater->read(at, some) < some) throw damaged;
            } else {
                std::memcpy(at, state->stored.data(), some);
                state->stored.remove_prefix(some);
            }
            state->crc = crc32_z(state->crc, reinterpret_cast<const Bytef*>(at), some);
            at += some;
            left -= some;
        }
        state->left -= count;
        if (state->left == 0 && state->crc != expected) throw damaged;
    };
    return {member.size, read};
}

}  // namespace clvotess

#include "files/formats/zip_writer.hpp"

#include <zlib.h>

#include <algorithm>

#include "files/output_file.hpp"
#include "interrupt.hpp"

namespace clvotess {
namespace {

constexpr unsigned version_plain = 20;
constexpr unsigned version_zip64 = 45;
constexpr unsigned made_by_unix = 3 << 8;
constexpr unsigned utf8_names = 1 << 11;
constexpr unsigned first_dos_date = (0 << 9) | (1 << 5) | 1;  // 1980-01-01, so that equal results give equal files
constexpr unsigned zip64_extra = 1;
constexpr std::uint32_t regular_file_mode = 0100644u << 16;
constexpr std::uint64_t see_zip64 = 0xffffffff;

// The little-endian fields of a record.
class Record {
public:
    Record& u16(std::uint64_t value) { return append(value, 2); }
    Record& u32(std::uint64_t value) { return append(value, 4); }
    Record& u64(std::uint64_t value) { return append(value, 8); }
    Record& text(std::string_view text) {
        bytes_ += text;
        return *this;
    }
    [[nodiscard]] const std::string& bytes() const { return bytes_; }

private:
    Record& append(std::uint64_t value, int count) {
        for (int i = 0; i < count; ++i) bytes_ += static_cast<char>(value >> (8 * i) & 0xff);
        return *this;
    }
    std::string bytes_;
};

std::uint32_t crc_of(std::span<const std::string_view> parts) {
    constexpr std::size_t piece = std::size_t{64} << 20;  // Ctrl-C works between pieces
    uLong crc = crc32_z(0, nullptr, 0);
    for (std::string_view part : parts) {
        while (!part.empty()) {
            throw_if_interrupted();
            const std::size_t count = std::min(part.size(), piece);
            crc = crc32_z(crc, reinterpret_cast<const Bytef*>(part.data()), count);
            part.remove_prefix(count);
        }
    }
    return static_cast<std::uint32_t>(crc);
}

}  // namespace

void ZipWriter::write(std::string_view bytes) {
    file_.write(bytes);
    position_ += bytes.size();
}

void ZipWriter::add(const std::string& name, std::span<const std::string_view> parts) {
    Member member{.name = name, .crc = crc_of(parts), .size = 0, .offset = position_};
    for (const std::string_view part : parts) member.size += part.size();
    const bool zip64 = needs_zip64(member.size);
    Record extra;
    if (zip64) extra.u16(zip64_extra).u16(16).u64(member.size).u64(member.size);
    const std::uint64_t size = zip64 ? see_zip64 : member.size;
    Record header;
    header.u32(0x04034b50).u16(zip64 ? version_zip64 : version_plain).u16(utf8_names);
    header.u16(0).u16(0).u16(first_dos_date);  // stored; time; date
    header.u32(member.crc).u32(size).u32(size).u16(name.size()).u16(extra.bytes().size());
    header.text(name).text(extra.bytes());
    write(header.bytes());
    for (const std::string_view part : parts) write(part);
    members_.push_back(member);
}

void ZipWriter::finish() {
    const std::uint64_t directory_begin = position_;
    bool any_zip64 = false;
    for (const Member& member : members_) {
        const bool long_size = needs_zip64(member.size);
        const bool long_offset = needs_zip64(member.offset);
        Record fields;
        if (long_size) fields.u64(member.size).u64(member.size);
        if (long_offset) fields.u64(member.offset);
        Record extra;
        if (long_size || long_offset) extra.u16(zip64_extra).u16(fields.bytes().size()).text(fields.bytes());
        const unsigned version = long_size || long_offset ? version_zip64 : version_plain;
        const std::uint64_t size = long_size ? see_zip64 : member.size;
        Record entry;
        entry.u32(0x02014b50).u16(made_by_unix | version).u16(version).u16(utf8_names);
        entry.u16(0).u16(0).u16(first_dos_date);
        entry.u32(member.crc).u32(size).u32(size).u16(member.name.size()).u16(extra.bytes().size());
        entry.u16(0).u16(0).u16(0).u32(regular_file_mode);  // comment, disk, internal and external attributes
        entry.u32(long_offset ? see_zip64 : member.offset).text(member.name).text(extra.bytes());
        write(entry.bytes());
        any_zip64 |= long_size || long_offset;
    }
    const std::uint64_t directory_size = position_ - directory_begin;
    const std::uint64_t count = members_.size();
    Record end;
    const bool long_directory = needs_zip64(directory_begin);
    if (any_zip64 || long_directory) {
        const std::uint64_t record_begin = position_;
        end.u32(0x06064b50).u64(44).u16(made_by_unix | version_zip64).u16(version_zip64).u32(0).u32(0);
        end.u64(count).u64(count).u64(directory_size).u64(directory_begin);
        end.u32(0x07064b50).u32(0).u64(record_begin).u32(1);  // offset of the record above
    }
    end.u32(0x06054b50).u16(0).u16(0).u16(count).u16(count).u32(directory_size);
    end.u32(long_directory ? see_zip64 : directory_begin).u16(0);
    write(end.bytes());
}

}  // namespace clvotess

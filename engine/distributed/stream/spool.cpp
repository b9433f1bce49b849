#include "distributed/stream/spool.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/arithmetic.hpp"
#include "core/disk_space.hpp"
#include "core/errors.hpp"
#include "votess/votess.hpp"

namespace votess::stream {
namespace {

[[noreturn]] void fail(const std::string& what) {
    throw Error(ErrorCode::storage, "temporary file: " + what + ": " + std::strerror(errno));
}

}  // namespace

std::string temporary_folder(const std::string& folder) {
    return folder.empty() ? system::text_of(system::temporary_folder()) : folder;
}

std::uint64_t free_bytes(const std::string& folder) {
    std::error_code problem;
    const std::filesystem::space_info space = std::filesystem::space(system::path_of(folder), problem);
    if (problem)
        throw Error(ErrorCode::invalid_argument,
                    "the folder of temporary files '" + folder + "' cannot be used: " + problem.message());
    return space.available;
}

TemporaryFile::TemporaryFile(const std::string& folder, DiskUse& use)
    : file_(system::File::temporary(system::path_of(temporary_folder(folder)))), use_(use) {
    if (!file_.is_open()) fail("it cannot be made in '" + temporary_folder(folder) + "'");
}

std::uint64_t TemporaryFile::append(std::span<const std::byte> bytes) {
    const std::uint64_t begin = size_;
    while (!bytes.empty()) {
        const std::ptrdiff_t done = file_.write_at(size_, bytes);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) fail("it cannot grow beyond " + std::to_string(size_) + " bytes");
        size_ += static_cast<std::uint64_t>(done);
        bytes = bytes.subspan(static_cast<std::size_t>(done));
    }
    on_disk_ += size_ - begin;
    use_.add(size_ - begin);
    return begin;
}

void TemporaryFile::read(std::uint64_t at, std::span<std::byte> to) const {
    while (!to.empty()) {
        const std::ptrdiff_t done = file_.read_at(at, to);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) fail("it cannot be read at " + std::to_string(at));
        at += static_cast<std::uint64_t>(done);
        to = to.subspan(static_cast<std::size_t>(done));
    }
}

void TemporaryFile::release(std::uint64_t begin, std::uint64_t end) {
    constexpr std::uint64_t page = 4096;  // others may need the rest of the first and of the last one
    begin = round_up(begin, page);
    end = end / page * page;
    if (begin >= end || !system::release_disk_space(file_, begin, end - begin)) return;
    on_disk_ -= end - begin;
    use_.subtract(end - begin);
}

void Spool::append_bytes(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    const std::uint64_t at = file_->append(bytes);
    if (!extents_.empty() && extents_.back().at + extents_.back().size == at)
        extents_.back().size += bytes.size();
    else
        extents_.push_back({at, bytes.size()});
}

Spool::Place Spool::after(Place at, std::uint64_t bytes) const {
    at.within += bytes;
    while (at.extent < extents_.size() && at.within >= extents_[at.extent].size)
        at.within -= extents_[at.extent++].size;
    return at;
}

Spool::Place Spool::read_bytes(Place at, std::span<std::byte> to) const {
    while (!to.empty()) {
        if (at.extent == extents_.size()) bug("a spool is read beyond its end");
        const Extent& extent = extents_[at.extent];
        const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(to.size(), extent.size - at.within));
        file_->read(extent.at + at.within, to.first(size));
        at = after(at, size);
        to = to.subspan(size);
    }
    return at;
}

// Calls are slow, so many bytes leave at once.
void Spool::release() {
    constexpr std::uint64_t at_once = std::uint64_t{4} << 20;
    for (; released_.extent < at_.extent; ++released_.extent, released_.within = 0) {
        const Extent& extent = extents_[released_.extent];
        file_->release(extent.at + released_.within, extent.at + extent.size);
    }
    if (at_.within - released_.within < at_once) return;
    const std::uint64_t begin = extents_[at_.extent].at;
    file_->release(begin + released_.within, begin + at_.within);
    released_ = at_;
}

void Spool::next_piece() {
    PackedHead head;
    at_ = read_bytes(at_, std::as_writable_bytes(std::span(&head, 1)));
    unpacker_ = Unpacker(head);
}

void Spool::read_values(std::span<std::byte> to) {
    constexpr std::size_t at_once = 16384;
    std::vector<std::byte> packed;
    while (!to.empty()) {
        if (unpacker_.values() == 0) next_piece();
        const PackedHead& head = unpacker_.head();
        if (to.size() % head.each != 0) bug("a spool has values of another size");
        const std::uint64_t before = unpacker_.values();
        if (head.is_plain()) {
            const auto bytes =
                to.first(static_cast<std::size_t>(std::min<std::uint64_t>(to.size(), unpacker_.bytes())));
            at_ = read_bytes(at_, bytes);
            unpacker_.skip(bytes.size());
            to = to.subspan(bytes.size());
        } else {
            packed.resize(static_cast<std::size_t>(std::min<std::uint64_t>(at_once, unpacker_.bytes())));
            (void)read_bytes(at_, packed);
            const Unpacker::Done done = unpacker_.unpack(packed, to);
            at_ = after(at_, done.used);
            to = to.subspan(done.written);
        }
        read_ += before - unpacker_.values();
    }
    if (releases_) release();
}

}  // namespace votess::stream

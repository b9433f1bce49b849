#include "distributed/stream/spool.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

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

TemporaryFile::TemporaryFile(const std::string& folder)
    : file_(system::File::temporary(system::path_of(temporary_folder(folder)))) {
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

void Spool::append_bytes(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    const std::uint64_t at = file_->append(bytes);
    size_ += bytes.size();
    if (!extents_.empty() && extents_.back().at + extents_.back().size == at)
        extents_.back().size += bytes.size();
    else
        extents_.push_back({at, bytes.size()});
}

void Spool::read_bytes(std::span<std::byte> to) {
    if (to.size() > remaining()) bug("a spool is read beyond its end");
    read_ += to.size();
    while (!to.empty()) {
        const Extent& extent = extents_[extent_];
        const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(to.size(), extent.size - within_));
        file_->read(extent.at + within_, to.first(size));
        within_ += size;
        if (within_ == extent.size) ++extent_, within_ = 0;
        to = to.subspan(size);
    }
}

}  // namespace votess::stream

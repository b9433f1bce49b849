#include "distributed/stream/spool.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "votess/votess.hpp"

namespace votess::stream {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& what) {
    throw Error(ErrorCode::storage, "temporary file: " + what + ": " + std::strerror(errno));
}

}  // namespace

std::string temporary_folder(const std::string& folder) {
    if (!folder.empty()) return folder;
    const char* const named = std::getenv("TMPDIR");
    return named != nullptr && *named != '\0' ? named : "/tmp";
}

std::uint64_t free_bytes(const std::string& folder) {
    std::error_code problem;
    const fs::space_info space = fs::space(folder, problem);
    if (problem)
        throw Error(ErrorCode::invalid_argument,
                    "the folder of temporary files '" + folder + "' cannot be used: " + problem.message());
    return space.available;
}

TemporaryFile::TemporaryFile(const std::string& folder) {
#ifdef O_TMPFILE
    descriptor_ = ::open(temporary_folder(folder).c_str(), O_TMPFILE | O_EXCL | O_RDWR | O_CLOEXEC, 0600);
    if (descriptor_ >= 0) return;
#endif
    std::string name = (fs::path(temporary_folder(folder)) / ".votess-XXXXXX").string();
    descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor_ < 0) fail("it cannot be made in '" + temporary_folder(folder) + "'");
    ::unlink(name.c_str());
}

TemporaryFile::~TemporaryFile() {
    ::close(descriptor_);
}

std::uint64_t TemporaryFile::append(std::span<const std::byte> bytes) {
    const std::uint64_t begin = size_;
    while (!bytes.empty()) {
        const ssize_t done = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(size_));
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) fail("it cannot grow beyond " + std::to_string(size_) + " bytes");
        size_ += static_cast<std::uint64_t>(done);
        bytes = bytes.subspan(static_cast<std::size_t>(done));
    }
    return begin;
}

void TemporaryFile::read(std::uint64_t at, std::span<std::byte> to) const {
    while (!to.empty()) {
        const ssize_t done = ::pread(descriptor_, to.data(), to.size(), static_cast<off_t>(at));
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
    if (to.size() > remaining()) throw Error(ErrorCode::internal, "a bug in votess: a spool is read beyond its end");
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

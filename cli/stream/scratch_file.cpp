#include "stream/scratch_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "failure.hpp"

namespace clvotess {
namespace {

[[nodiscard]] Failure failed(const std::string& folder) {
    return runtime_failure("cannot use a temporary file in " + in_quotes(folder) + ": " + std::strerror(errno) +
                           ": name another folder with --temporary");
}

}  // namespace

ScratchFile::ScratchFile(const std::string& folder) : folder_(folder) {
#ifdef O_TMPFILE
    descriptor_ = open(folder.c_str(), O_TMPFILE | O_EXCL | O_RDWR | O_CLOEXEC, 0600);
    if (descriptor_ >= 0) return;
#endif
    std::string name = folder + "/.clvotess-XXXXXX";
    descriptor_ = mkostemp(name.data(), O_CLOEXEC);
    if (descriptor_ < 0) throw failed(folder_);
    unlink(name.c_str());
}

ScratchFile::~ScratchFile() {
    close(descriptor_);
}

void ScratchFile::write(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) throw failed(folder_);
        size_ += static_cast<std::uint64_t>(done);
        bytes.remove_prefix(static_cast<std::size_t>(done));
    }
}

void ScratchFile::rewind() {
    if (lseek(descriptor_, 0, SEEK_SET) < 0) throw failed(folder_);
}

void ScratchFile::read(void* to, std::size_t bytes) {
    auto* at = static_cast<char*>(to);
    while (bytes > 0) {
        const ssize_t done = ::read(descriptor_, at, bytes);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) throw failed(folder_);
        at += done;
        bytes -= static_cast<std::size_t>(done);
    }
}

void ScratchFile::add_to(std::uint64_t place, double value) {
    double sum = 0;
    const auto at = static_cast<off_t>(place);
    if (pread(descriptor_, &sum, sizeof sum, at) != sizeof sum) throw failed(folder_);
    sum += value;
    if (pwrite(descriptor_, &sum, sizeof sum, at) != sizeof sum) throw failed(folder_);
}

}  // namespace clvotess

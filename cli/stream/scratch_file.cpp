#include "stream/scratch_file.hpp"

#include <cerrno>
#include <cstring>
#include <span>

#include "failure.hpp"

namespace clvotess {
namespace {

[[nodiscard]] Failure failed(const std::string& folder) {
    return runtime_failure("cannot use a temporary file in " + in_quotes(folder) + ": " + std::strerror(errno) +
                           ": name another folder with --temporary");
}

}  // namespace

ScratchFile::ScratchFile(const std::string& folder)
    : folder_(folder), file_(votess::system::File::temporary(votess::system::path_of(folder))) {
    if (!file_.is_open()) throw failed(folder_);
}

void ScratchFile::write(std::string_view bytes) {
    while (!bytes.empty()) {
        const std::ptrdiff_t done = file_.write(std::as_bytes(std::span(bytes)));
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) throw failed(folder_);
        size_ += static_cast<std::uint64_t>(done);
        bytes.remove_prefix(static_cast<std::size_t>(done));
    }
}

void ScratchFile::rewind() {
    if (!file_.rewind()) throw failed(folder_);
}

void ScratchFile::read(void* to, std::size_t bytes) {
    std::span left(static_cast<std::byte*>(to), bytes);
    while (!left.empty()) {
        const std::ptrdiff_t done = file_.read(left);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) throw failed(folder_);
        left = left.subspan(static_cast<std::size_t>(done));
    }
}

void ScratchFile::add_to(std::uint64_t place, double value) {
    double sum = 0;
    const std::span bytes = std::as_writable_bytes(std::span(&sum, 1));
    constexpr std::ptrdiff_t all = sizeof sum;
    if (file_.read_at(place, bytes) != all) throw failed(folder_);
    sum += value;
    if (file_.write_at(place, bytes) != all) throw failed(folder_);
}

}  // namespace clvotess

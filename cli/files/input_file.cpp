#include "files/input_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "failure.hpp"
#include "files/limits.hpp"
#include "interrupt.hpp"

namespace clvotess {
namespace {

// Opens a file. A signal interrupts the wait for the writer of a FIFO.
int open_file(const std::string& path) {
    for (;;) {
        throw_if_interrupted();
        const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
        if (descriptor >= 0) return descriptor;
        if (errno != EINTR) throw bad_input("cannot open " + in_quotes(path) + ": " + std::strerror(errno));
    }
}

}  // namespace

InputFile::InputFile(const std::string& path)
    : name_(path == "-" ? "stdin" : path), descriptor_(path == "-" ? STDIN_FILENO : open_file(path)) {
    struct stat facts {};
    regular_ = path != "-" && fstat(descriptor_, &facts) == 0 && S_ISREG(facts.st_mode);
    if (regular_) size_ = static_cast<std::uint64_t>(facts.st_size);
}

InputFile::~InputFile() {
    if (descriptor_ != STDIN_FILENO) close(descriptor_);
}

std::size_t InputFile::read(char* to, std::size_t count) {
    constexpr std::size_t piece = std::size_t{1} << 24;
    std::size_t done = 0;
    while (done < count) {
        throw_if_interrupted();
        const ssize_t got = ::read(descriptor_, to + done, std::min(piece, count - done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) {
            throw bad_input("cannot read " + (descriptor_ == STDIN_FILENO ? name_ : in_quotes(name_)) + ": " +
                            std::strerror(errno));
        }
        if (got == 0) break;
        done += static_cast<std::size_t>(got);
    }
    done_ += done;
    if (done < count && done_ < size_) throw runtime_failure(name_ + ": the file was made shorter while it was read");
    return done;
}

bool InputFile::append(std::string& to, std::size_t count) {
    const std::size_t before = to.size();
    to.resize(before + count);
    const std::size_t got = read(to.data() + before, count);
    to.resize(before + got);
    return got == count;
}

void InputFile::skip(std::uint64_t count) {
    if (lseek(descriptor_, static_cast<off_t>(count), SEEK_CUR) < 0)
        throw runtime_failure("cannot read " + in_quotes(name_) + ": " + std::strerror(errno));
    done_ += count;
}

void check_last_line(std::string_view text, const std::string& name) {
    if (text.size() <= max_line || text.rfind('\n') + 1 + max_line >= text.size()) return;
    throw bad_input(name + ": not a text: it holds a line of more than " + std::to_string(max_line) + " bytes");
}

std::string read_whole(const std::string& path, bool lines) {
    constexpr std::size_t piece = std::size_t{1} << 22;
    InputFile file(path);
    std::string bytes;
    // One byte more than expected, so that the end shows without another read.
    bytes.reserve(static_cast<std::size_t>(file.size()) + 1);
    bool more = true;
    while (more) {
        const std::size_t before = bytes.size();
        const std::size_t left = bytes.capacity() - before;
        more = file.append(bytes, left > 0 ? std::min(left, piece) : piece);
        if (lines)
            check_last_line(std::string_view(bytes).substr(before - std::min(before, max_line + 1)), file.name());
    }
    return bytes;
}

}  // namespace clvotess

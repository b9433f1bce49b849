#include "files/input_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>

#include "failure.hpp"
#include "files/limits.hpp"
#include "interrupt.hpp"

namespace clvotess {
namespace {

using votess::system::File;

// Opens a file. A signal interrupts the wait for the writer of a FIFO.
File open_file(const std::string& path) {
    for (;;) {
        throw_if_interrupted();
        File file = File::open_to_read(votess::system::path_of(path));
        if (file.is_open()) return file;
        if (errno != EINTR) throw bad_input("cannot open " + in_quotes(path) + ": " + std::strerror(errno));
    }
}

}  // namespace

InputFile::InputFile(const std::string& path)
    : name_(path == "-" ? "stdin" : path), file_(path == "-" ? File::standard_input() : open_file(path)) {
    if (path != "-") regular_size_ = file_.regular_size();
}

std::size_t InputFile::read(char* to, std::size_t count) {
    constexpr std::size_t piece = std::size_t{1} << 24;
    std::size_t done = 0;
    while (done < count) {
        throw_if_interrupted();
        const std::ptrdiff_t got =
            file_.read(std::as_writable_bytes(std::span(to + done, std::min(piece, count - done))));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) {
            throw bad_input("cannot read " + (file_.is_standard() ? name_ : in_quotes(name_)) + ": " +
                            std::strerror(errno));
        }
        if (got == 0) break;
        done += static_cast<std::size_t>(got);
    }
    done_ += done;
    if (done < count && done_ < size()) throw runtime_failure(name_ + ": the file was made shorter while it was read");
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
    if (!file_.skip(count)) throw runtime_failure("cannot read " + in_quotes(name_) + ": " + std::strerror(errno));
    done_ += count;
}

void check_last_line(std::string_view text, const std::string& name) {
    if (text.size() <= max_line || text.rfind('\n') + 1 + max_line >= text.size()) return;
    throw bad_input(name + ": not a text: it holds a line of more than " + std::to_string(max_line) + " bytes");
}

std::string read_whole(const std::string& path) {
    constexpr std::size_t piece = std::size_t{1} << 22;
    InputFile file(path);
    if (path != "-" && file.is_device()) throw bad_input(in_quotes(path) + " is a device: give a file");
    std::string bytes;
    // One byte more than expected, so that the end shows without another read.
    bytes.reserve(static_cast<std::size_t>(file.size()) + 1);
    bool more = true;
    while (more) {
        const std::size_t left = bytes.capacity() - bytes.size();
        more = file.append(bytes, left > 0 ? std::min(left, piece) : piece);
    }
    return bytes;
}

}  // namespace clvotess

#include "stream/sequential_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "failure.hpp"
#include "interrupt.hpp"

namespace clvotess {

SequentialFile::SequentialFile(const std::string& path)
    : path_(path), descriptor_(path == "-" ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) throw bad_input("cannot open " + in_quotes(path) + ": " + std::strerror(errno));
}

SequentialFile::~SequentialFile() {
    if (descriptor_ != STDIN_FILENO) close(descriptor_);
}

bool SequentialFile::append(std::string& to, std::size_t bytes) {
    std::size_t used = to.size();
    const std::size_t end = used + bytes;
    to.resize(end);
    while (used < end) {
        const ssize_t got = read(descriptor_, to.data() + used, end - used);
        if (got < 0 && errno == EINTR) {
            throw_if_interrupted();
            continue;
        }
        if (got < 0)
            throw bad_input("cannot read " + (path_ == "-" ? "stdin" : in_quotes(path_)) + ": " + std::strerror(errno));
        if (got == 0) break;
        used += static_cast<std::size_t>(got);
    }
    to.resize(used);
    return used == end;
}

}  // namespace clvotess

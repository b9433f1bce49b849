#include "files/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "failure.hpp"

namespace clvotess {
namespace {

class Descriptor {
public:
    explicit Descriptor(const std::string& path)
        : value_(path == "-" ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
        if (value_ < 0) throw bad_input("cannot open " + in_quotes(path) + ": " + std::strerror(errno));
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (value_ != STDIN_FILENO) close(value_);
    }
    [[nodiscard]] int value() const noexcept { return value_; }

private:
    int value_;
};

std::string read_all(int descriptor, const std::string& name) {
    constexpr std::size_t piece = std::size_t{1} << 20;
    std::string bytes(piece, '\0');
    std::size_t used = 0;
    for (;;) {
        if (used == bytes.size()) bytes.resize(bytes.size() + std::max(piece, bytes.size() / 2));
        const ssize_t got = read(descriptor, bytes.data() + used, bytes.size() - used);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw bad_input("cannot read " + in_quotes(name) + ": " + std::strerror(errno));
        if (got == 0) break;
        used += static_cast<std::size_t>(got);
    }
    bytes.resize(used);
    return bytes;
}

}  // namespace

MappedFile::MappedFile(const std::string& path) {
    const Descriptor file(path);
    struct stat facts {};
    const bool regular = path != "-" && fstat(file.value(), &facts) == 0 && S_ISREG(facts.st_mode);
    if (regular && facts.st_size > 0) {
        const auto size = static_cast<std::size_t>(facts.st_size);
        void* const mapping = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.value(), 0);
        if (mapping != MAP_FAILED) {
            mapping_ = mapping;
            bytes_ = {static_cast<const char*>(mapping), size};
            madvise(mapping_, size, MADV_SEQUENTIAL);
            return;
        }
    }
    copy_ = read_all(file.value(), path == "-" ? "stdin" : path);
    bytes_ = copy_;
}

MappedFile::~MappedFile() {
    if (mapping_) munmap(mapping_, bytes_.size());
}

}  // namespace clvotess

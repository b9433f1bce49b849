#include "files/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "failure.hpp"
#include "interrupt.hpp"

namespace clvotess {
namespace {

namespace fs = std::filesystem;

// Follows links, also one whose target is still to be made.
std::string resolved(const std::string& path) {
    std::error_code problem;
    fs::path real = fs::absolute(path, problem);
    if (problem) {
        throw bad_input("cannot tell where " + in_quotes(path) +
                        " lies, for the working directory is gone: " + "go to another, or give the whole path");
    }
    constexpr int most_links = 40;  // as Linux follows; beyond it links make a circle
    for (int k = 0; k < most_links && fs::is_symlink(fs::symlink_status(real, problem)); ++k) {
        real = real.parent_path() / fs::read_symlink(real, problem);
    }
    const fs::path canonical = fs::weakly_canonical(real, problem);
    return problem ? real.string() : canonical.string();
}

std::string folder_of(const std::string& path) {
    const fs::path folder = fs::path(path).parent_path();
    return folder.empty() ? "." : folder.string();
}

Failure cannot_write(const std::string& what, int error) {
    return runtime_failure("cannot write " + what + ": " + std::strerror(error));
}

}  // namespace

bool is_special_file(const std::string& path) {
    std::error_code problem;
    const fs::file_status status = fs::status(path, problem);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

void check_writable(const std::string& path) {
    const std::string target = resolved(path);
    std::error_code problem;
    const auto refuse = [&](const std::string& why) {
        throw bad_input("cannot write " + in_quotes(path) + ": " + why);
    };
    const fs::file_status status = fs::status(target, problem);
    if (status.type() == fs::file_type::none) refuse(problem.message());
    if (fs::is_directory(status)) refuse("it is a folder");
    if (fs::exists(status)) {
        if (access(target.c_str(), W_OK) != 0) refuse(std::strerror(errno));
        if (!fs::is_regular_file(status)) return;
    }
    const std::string folder = folder_of(target);
    if (!fs::is_directory(folder, problem)) refuse("there is no folder " + in_quotes(folder));
    if (access(folder.c_str(), W_OK | X_OK) != 0) refuse("folder " + in_quotes(folder) + ": " + std::strerror(errno));
}

std::string identity_of(const std::string& path) {
    return path == "-" ? path : resolved(path);
}

OutputFile::OutputFile(const std::string& path) : name_(path), target_(path) {
    if (path == "-") {
        descriptor_ = STDOUT_FILENO;
        return;
    }
    if (is_special_file(path)) {
        // Opening a pipe waits for its reader.
        while ((descriptor_ = open(path.c_str(), O_WRONLY | O_CLOEXEC)) < 0) {
            if (errno != EINTR) throw cannot_write(description(), errno);
            throw_if_interrupted();
        }
        return;
    }
    target_ = resolved(path);
    struct stat old {};
    const bool replaces = stat(target_.c_str(), &old) == 0;
    // Short, so that it fits where the target's own name fits.
    for (int attempt = 0; descriptor_ < 0; ++attempt) {
        temporary_ =
            folder_of(target_) + "/.clvotess-" + std::to_string(getpid()) + "-" + std::to_string(attempt) + ".tmp";
        descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor_ < 0 && (errno != EEXIST || attempt == 1000)) {
            const int error = errno;
            temporary_.clear();
            throw cannot_write(description(), error);
        }
    }
    if (replaces) {  // best effort: the new file keeps the permissions of the one it replaces
        [[maybe_unused]] const int ignored = fchmod(descriptor_, old.st_mode & 07777);
    }
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : name_(std::move(other.name_)),
      target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

OutputFile::~OutputFile() {
    close_quietly();
    if (!temporary_.empty()) unlink(temporary_.c_str());
}

void OutputFile::write(std::string_view bytes) {
    // Small enough that Ctrl-C is heard soon.
    constexpr std::size_t piece = std::size_t{8} << 20;
    while (!bytes.empty()) {
        throw_if_interrupted();
        const ssize_t written = ::write(descriptor_, bytes.data(), std::min(bytes.size(), piece));
        if (written < 0) {
            if (errno == EINTR) continue;
            if (errno == EPIPE && name_ == "-") throw Interrupted(SIGPIPE);
            throw cannot_write(description(), errno);
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
}

const std::string& OutputFile::path_for_library() const {
    if (temporary_.empty()) {
        throw bad_input("cannot write " + description() + ": this format needs a regular file, not a device or a pipe");
    }
    return temporary_;
}

Failure OutputFile::write_failure(int error) const {
    if (error == 0) return runtime_failure("cannot write " + description());
    return cannot_write(description(), error);
}

void OutputFile::finish() {
    if (descriptor_ == STDOUT_FILENO) {
        descriptor_ = -1;
        return;
    }
    // Some file systems report a full disk only here.
    if (close(std::exchange(descriptor_, -1)) != 0 && errno != EINTR) throw cannot_write(description(), errno);
}

void OutputFile::publish() {
    if (temporary_.empty()) return;
    if (rename(temporary_.c_str(), target_.c_str()) != 0) throw cannot_write(description(), errno);
    temporary_.clear();
}

std::string OutputFile::description() const {
    return name_ == "-" ? "to stdout" : in_quotes(name_);
}

void OutputFile::close_quietly() noexcept {
    if (descriptor_ > STDERR_FILENO) close(descriptor_);
    descriptor_ = -1;
}

}  // namespace clvotess

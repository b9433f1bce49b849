#include "files/output_file.hpp"

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

// Follows links, also to a target that does not exist yet.
std::string resolved(const std::string& path) {
    std::error_code problem;
    fs::path real = fs::absolute(path, problem);
    if (problem) {
        throw bad_input("cannot find " + in_quotes(path) +
                        ": the working directory was deleted: change to another, or give an absolute path");
    }
    constexpr int max_links = 40;  // the limit of Linux; more links are a circle
    for (int k = 0; k < max_links && fs::is_symlink(fs::symlink_status(real, problem)); ++k) {
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

// Returns 0 or an error number. A file system without fsync() is not an error.
int sync(int descriptor) {
    while (fsync(descriptor) != 0) {
        if (errno == EINTR) continue;
        const bool unknown = errno == EINVAL || errno == EROFS || errno == ENOTSUP || errno == ENOSYS;
        return unknown ? 0 : errno;
    }
    return 0;
}

// Returns 0 or an error number. A folder without read permission is not synced.
int sync_folder(const std::string& folder) {
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return errno == EACCES ? 0 : errno;
    const int error = sync(descriptor);
    close(descriptor);
    return error;
}

// Returns a path that opens the file again, even if it has no name.
std::string path_of(int descriptor) {
    return "/proc/self/fd/" + std::to_string(descriptor);
}

// Returns the first free name in the target's folder for which make() succeeds; "" on another error, with errno set.
// The name is short, so that it fits where the target's name fits.
template <class Make>
std::string with_free_name(const std::string& target, const Make& make) {
    for (int attempt = 0; attempt <= 1000; ++attempt) {
        std::string name =
            folder_of(target) + "/.clvotess-" + std::to_string(getpid()) + "-" + std::to_string(attempt) + ".tmp";
        if (make(name.c_str())) return name;
        if (errno != EEXIST) break;
    }
    return {};
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
    if (fs::is_directory(status)) refuse("it is a folder: give the name of a file");
    if (fs::exists(status)) {
        if (access(target.c_str(), W_OK) != 0) refuse(std::strerror(errno));
        if (!fs::is_regular_file(status)) return;
    }
    const std::string folder = folder_of(target);
    if (!fs::is_directory(folder, problem))
        refuse("there is no folder " + in_quotes(folder) + ": create it, or name another");
    if (access(folder.c_str(), W_OK | X_OK) != 0) refuse("folder " + in_quotes(folder) + ": " + std::strerror(errno));
}

std::string identity_of(const std::string& path) {
    return path == "-" ? path : resolved(path);
}

void sync_file(const std::string& path) {
    const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    const int error = descriptor < 0 ? errno : sync(descriptor);
    if (descriptor >= 0) close(descriptor);
    if (error != 0) throw cannot_write(in_quotes(path), error);
}

OutputFile::OutputFile(const std::string& path, Temporary temporary) : name_(path) {
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
    open_temporary(temporary);
    if (replaces) {  // best effort: the new file keeps the permissions of the one it replaces
        [[maybe_unused]] const int ignored = fchmod(descriptor_, old.st_mode & 07777);
    }
}

void OutputFile::open_temporary(Temporary temporary) {
#ifdef O_TMPFILE
    if (temporary == Temporary::unnamed) {
        descriptor_ = open(folder_of(target_).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
        // Without /proc the file could not get a name later.
        if (descriptor_ >= 0 && access(path_of(descriptor_).c_str(), F_OK) != 0) close_quietly();
    }
#endif
    if (descriptor_ >= 0) return;
    temporary_ = with_free_name(target_, [&](const char* name) {
        descriptor_ = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        return descriptor_ >= 0;
    });
    if (temporary_.empty()) throw cannot_write(description(), errno);
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
    // Small, so that Ctrl-C works soon.
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

std::string OutputFile::path_for_library() const {
    if (target_.empty()) {
        throw bad_input("cannot write " + description() +
                        ": this format needs a regular file, not a device or a pipe: give the name of a file");
    }
    return temporary_.empty() ? path_of(descriptor_) : temporary_;
}

Failure OutputFile::write_failure(int error) const {
    if (error == 0) return runtime_failure("cannot write " + description());
    return cannot_write(description(), error);
}

void OutputFile::finish() {
    if (descriptor_ == STDOUT_FILENO) {
        descriptor_ = -1;
    } else if (target_.empty()) {
        // Some devices report an error only here.
        if (close(std::exchange(descriptor_, -1)) != 0 && errno != EINTR) throw cannot_write(description(), errno);
    } else if (const int error = sync(descriptor_); error != 0) {
        throw cannot_write(description(), error);
    }
}

void OutputFile::publish() {
    if (target_.empty()) return;
    const auto link = [&](const char* name) {
        return linkat(AT_FDCWD, path_of(descriptor_).c_str(), AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0;
    };
    const bool linked = temporary_.empty() && link(target_.c_str());
    if (!linked) {
        // A link cannot replace a file.
        if (temporary_.empty() && errno == EEXIST) temporary_ = with_free_name(target_, link);
        if (temporary_.empty() || rename(temporary_.c_str(), target_.c_str()) != 0)
            throw cannot_write(description(), errno);
        temporary_.clear();
    }
    close_quietly();
    if (const int error = sync_folder(folder_of(target_)); error != 0)
        throw runtime_failure(description() +
                              " is written, but its folder could not be synced: " + std::strerror(error));
}

std::string OutputFile::description() const {
    return name_ == "-" ? "to stdout" : in_quotes(name_);
}

void OutputFile::close_quietly() noexcept {
    if (descriptor_ > STDERR_FILENO) close(descriptor_);
    descriptor_ = -1;
}

}  // namespace clvotess

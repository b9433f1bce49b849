#include "files/output_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <span>
#include <utility>

#include "failure.hpp"
#include "interrupt.hpp"

namespace clvotess {
namespace {

namespace fs = std::filesystem;
using votess::system::File;
using votess::system::path_of;
using votess::system::text_of;

// Follows links, also to a target that does not exist yet.
std::string resolved(const std::string& path) {
    std::error_code problem;
    fs::path real = fs::absolute(path_of(path), problem);
    if (problem) {
        throw bad_input("cannot find " + in_quotes(path) +
                        ": the working directory was deleted: change to another, or give an absolute path");
    }
    constexpr int max_links = 40;  // the limit of Linux; more links are a circle
    for (int k = 0; k < max_links && fs::is_symlink(fs::symlink_status(real, problem)); ++k) {
        real = real.parent_path() / fs::read_symlink(real, problem);
    }
    const fs::path canonical = fs::weakly_canonical(real, problem);
    return text_of(problem ? real : canonical);
}

fs::path folder_of(const std::string& path) {
    const fs::path folder = path_of(path).parent_path();
    return folder.empty() ? "." : folder;
}

Failure cannot_write(const std::string& what, int error) {
    return runtime_failure("cannot write " + what + ": " + std::strerror(error));
}

// Returns the first free name in the target's folder for which make() succeeds; "" on another error, with errno set.
// The name is short, so that it fits where the target's name fits.
template <class Make>
std::string with_free_name(const std::string& target, const Make& make) {
    const std::string process = std::to_string(votess::system::process_id());
    for (int attempt = 0; attempt <= 1000; ++attempt) {
        const fs::path name = folder_of(target) / (".clvotess-" + process + "-" + std::to_string(attempt) + ".tmp");
        if (make(name)) return text_of(name);
        if (errno != EEXIST) break;
    }
    return {};
}

}  // namespace

bool is_special_file(const std::string& path) {
    std::error_code problem;
    const fs::file_status status = fs::status(path_of(path), problem);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

void check_writable(const std::string& path) {
    const std::string target = resolved(path);
    std::error_code problem;
    const auto refuse = [&](const std::string& why) {
        throw bad_input("cannot write " + in_quotes(path) + ": " + why);
    };
    const fs::file_status status = fs::status(path_of(target), problem);
    if (status.type() == fs::file_type::none) refuse(problem.message());
    if (fs::is_directory(status)) refuse("it is a folder: give the name of a file");
    if (fs::exists(status)) {
        if (!votess::system::may_write(path_of(target))) refuse(std::strerror(errno));
        if (!fs::is_regular_file(status)) return;
    }
    const fs::path folder = folder_of(target);
    const std::string name = in_quotes(text_of(folder));
    if (!fs::is_directory(folder, problem)) refuse("there is no folder " + name + ": create it, or name another");
    if (!votess::system::may_write(folder)) refuse("folder " + name + ": " + std::strerror(errno));
}

std::string identity_of(const std::string& path) {
    return path == "-" ? path : resolved(path);
}

void sync_file(const std::string& path) {
    const File file = File::open_to_read(path_of(path));
    const int error = file.is_open() ? file.sync() : errno;
    if (error != 0) throw cannot_write(in_quotes(path), error);
}

OutputFile::OutputFile(const std::string& path, Temporary temporary) : name_(path) {
    if (path == "-") {
        file_ = File::standard_output();
        return;
    }
    if (is_special_file(path)) {
        // Opening a pipe waits for its reader.
        while (!(file_ = File::open_to_write(path_of(path))).is_open()) {
            if (errno != EINTR) throw cannot_write(description(), errno);
            throw_if_interrupted();
        }
        return;
    }
    target_ = resolved(path);
    std::error_code problem;
    const fs::file_status old = fs::status(path_of(target_), problem);
    open_temporary(temporary);
    // Best effort: the new file keeps the permissions of the one it replaces.
    if (fs::exists(old)) fs::permissions(path_of(path_for_library()), old.permissions(), problem);
}

void OutputFile::open_temporary(Temporary temporary) {
    if (temporary == Temporary::unnamed) file_ = File::nameless(folder_of(target_));
    if (file_.is_open()) return;
    temporary_ = with_free_name(target_, [&](const fs::path& name) { return (file_ = File::create(name)).is_open(); });
    if (temporary_.empty()) throw cannot_write(description(), errno);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : name_(std::move(other.name_)),
      target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      file_(std::move(other.file_)),
      beside_(std::move(other.beside_)),
      made_(std::exchange(other.made_, {})) {}

OutputFile::~OutputFile() {
    (void)file_.close();
    std::error_code problem;
    if (!temporary_.empty()) fs::remove(path_of(temporary_), problem);
    beside_.clear();
    while (!made_.empty()) {
        fs::remove(made_.back(), problem);  // stays if others put files there
        made_.pop_back();
    }
}

void OutputFile::write(std::string_view bytes) {
    // Small, so that Ctrl-C works soon.
    constexpr std::size_t piece = std::size_t{8} << 20;
    while (!bytes.empty()) {
        throw_if_interrupted();
        const std::ptrdiff_t written = file_.write(std::as_bytes(std::span(bytes.substr(0, piece))));
        if (written < 0) {
            if (errno == EINTR) continue;
            if (errno == EPIPE && name_ == "-") throw Interrupted(votess::system::closed_pipe);
            throw cannot_write(description(), errno);
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
}

void OutputFile::require_regular() const {
    if (target_.empty()) {
        throw bad_input("cannot write " + description() +
                        ": this format needs a regular file, not a device or a pipe: give the name of a file");
    }
}

void OutputFile::make_folders(const fs::path& folder, std::error_code& problem) {
    if (fs::exists(folder, problem) || problem) return;
    make_folders(folder.parent_path(), problem);
    if (!problem && fs::create_directory(folder, problem)) made_.push_back(folder);
}

OutputFile& OutputFile::beside(const std::string& name) {
    require_regular();
    const fs::path path = folder_of(target_) / path_of(name);
    if (beside_.empty() || beside_.back().name_ != text_of(path)) {
        std::error_code problem;
        make_folders(path.parent_path(), problem);
        if (problem) throw runtime_failure("cannot write " + description() + ": " + problem.message());
        beside_.emplace_back(text_of(path));
    }
    return beside_.back();
}

std::string OutputFile::path_for_library() const {
    require_regular();
    return temporary_.empty() ? text_of(file_.path()) : temporary_;
}

Failure OutputFile::write_failure(int error) const {
    if (error == 0) return runtime_failure("cannot write " + description());
    return cannot_write(description(), error);
}

void OutputFile::finish() {
    for (OutputFile& file : beside_) file.finish();
    if (target_.empty()) {
        // Some devices report an error only here.
        if (!file_.close() && errno != EINTR) throw cannot_write(description(), errno);
    } else if (const int error = file_.sync(); error != 0) {
        throw cannot_write(description(), error);
    }
}

void OutputFile::publish() {
    for (OutputFile& file : beside_) file.publish();
    made_.clear();
    if (target_.empty()) return;
    const fs::path target = path_of(target_);
    const auto link = [&](const fs::path& name) { return file_.give_name(name); };
    const bool linked = temporary_.empty() && link(target);
    if (!linked) {
        // A link cannot replace a file.
        if (temporary_.empty() && errno == EEXIST) temporary_ = with_free_name(target_, link);
        if (temporary_.empty()) throw cannot_write(description(), errno);
        (void)file_.close();  // Windows renames no open file
        std::error_code problem;
        fs::rename(path_of(temporary_), target, problem);
        if (problem) throw runtime_failure("cannot write " + description() + ": " + problem.message());
        temporary_.clear();
    }
    (void)file_.close();
    if (const int error = votess::system::sync_folder(folder_of(target_)); error != 0)
        throw runtime_failure(description() +
                              " is written, but its folder could not be synced: " + std::strerror(error));
}

std::string OutputFile::description() const {
    return name_ == "-" ? "to stdout" : in_quotes(name_);
}

}  // namespace clvotess

#include "mpi/shared_file.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include "failure.hpp"

namespace clvotess {
namespace {

// The name that a signal handler removes. A handler may use little else, and MPI calls hang after the death of a rank.
std::array<char, 4096> temporary_of_handler{};
constexpr std::array signals{SIGINT, SIGTERM, SIGHUP};

// A signal during the creation of the file is handled when its name is known.
constexpr int settled = 0, making = -1;
std::atomic<int> state{settled};  // or the pending signal
static_assert(std::atomic<int>::is_always_lock_free);

void remove_and_end(int signal) {
    int expected = making;
    if (state.compare_exchange_strong(expected, signal)) return;
    if (temporary_of_handler[0] != '\0') std::remove(temporary_of_handler.data());
    std::_Exit(exit_code::signal_base + signal);
}

class MakingFile {
public:
    MakingFile() noexcept { state = making; }
    ~MakingFile() {
        if (const int signal = state.exchange(settled); signal != making) remove_and_end(signal);
    }
    MakingFile(const MakingFile&) = delete;
    MakingFile& operator=(const MakingFile&) = delete;
};

void remember(const std::string& temporary) {
    std::memcpy(temporary_of_handler.data(), temporary.c_str(), temporary.size() + 1);
}

}  // namespace

SharedFile::SharedFile(const Ranks& ranks, const std::string& path) : ranks_(ranks), name_(path) {
    for (const int signal : signals) std::signal(signal, remove_and_end);
    std::vector<char> bytes;
    ranks.first_alone([&] {
        const MakingFile guard;
        const std::string temporary = file_.emplace(path, OutputFile::Temporary::named).path_for_library();
        if (temporary.size() >= temporary_of_handler.size())
            throw bad_input("cannot write " + in_quotes(path) + ": its path is too long: give a shorter one");
        remember(temporary);
        bytes.assign(temporary.begin(), temporary.end());
    });
    ranks.broadcast(bytes);
    temporary_.assign(bytes.begin(), bytes.end());
    remember(temporary_);
    ranks.together([&] {
        std::error_code problem;
        if (!std::filesystem::exists(votess::system::path_of(temporary_), problem))
            throw runtime_failure("cannot see " + in_quotes(temporary_) +
                                  ", which rank 0 created: name a folder that all machines share");
    });
}

SharedFile::~SharedFile() {
    for (const int signal : signals) std::signal(signal, SIG_DFL);
    temporary_of_handler[0] = '\0';
}

Failure SharedFile::write_failure(int error) const {
    const std::string what = "cannot write " + in_quotes(name_);
    return runtime_failure(error == 0 ? what : what + ": " + std::strerror(error));
}

void SharedFile::publish() {
    ranks_.together([&] { sync_file(temporary_); });  // each machine syncs its own bytes
    ranks_.first_alone([&] {
        file_->finish();
        file_->publish();
    });
}

}  // namespace clvotess

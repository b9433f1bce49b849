// Calls of the library: a bar, Ctrl-C and exit codes. The bar goes to stderr. It is drawn when stderr is a terminal and
// the run lasts longer than a second.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <votess/progress.hpp>
#include <votess/votess.hpp>

#include "failure.hpp"
#include "interrupt.hpp"

namespace clvotess {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

class Progress {
public:
    Progress(bool enabled, Clock::time_point run_began);  // enabled: false for a quiet run
    ~Progress();                                          // erases the bar
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void show(double fraction);
    // Sets the name of the stage, shown behind the bar.
    void name(std::string stage) { stage_ = std::move(stage); }
    // Prints a line, unless the run is quiet.
    void say(const std::string& line);

private:
    bool quiet_;
    bool enabled_;
    bool drawn_ = false;
    Clock::time_point run_began_;
    std::string stage_;
};

// Returns work(callback). The callback goes to the library: it shows the bar and stops the call after a signal. Throws
// Interrupted after a signal.
template <class Work>
auto run_stoppable(Progress& progress, const Work& work) {
    const InterruptGuard guard;
    const votess::ProgressCallback callback = [&progress](double fraction) {
        progress.show(fraction);
        return interrupting_signal() == 0;
    };
    try {
        auto result = work(callback);
        throw_if_interrupted();
        return result;
    } catch (const votess::Error& error) {
        if (error.code() == votess::ErrorCode::cancelled) throw_if_interrupted();
        throw;
    }
}

// Watches calls of the library: each has a bar of its own, or none where a run of many frames has one.
class Watch {
public:
    Watch(bool quiet, Clock::time_point run_began) : quiet_(quiet), run_began_(run_began) {}
    Watch() = default;

    // Returns work(callback). Calls within it that take no callback are watched too. Throws Interrupted after a signal.
    template <class Work>
    auto operator()(const Work& work) const {
        const auto scoped = [&work](const votess::ProgressCallback& callback) {
            const votess::ProgressScope scope(callback);
            return work(callback);
        };
        if (!run_began_) return scoped([](double) { return interrupting_signal() == 0; });
        Progress progress(!quiet_, *run_began_);
        return run_stoppable(progress, scoped);
    }

private:
    bool quiet_ = true;
    std::optional<Clock::time_point> run_began_;
};

// Returns the exit code for an error of the library.
[[nodiscard]] inline int exit_code_of(votess::ErrorCode code) {
    const bool users = code == votess::ErrorCode::invalid_argument || code == votess::ErrorCode::unsupported;
    return users ? exit_code::bad_input : exit_code::runtime_failure;
}

}  // namespace clvotess

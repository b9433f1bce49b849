// Calls of the library: a bar, Ctrl-C and exit codes. The bar goes to stderr. It is drawn when stderr is a terminal and
// the run lasts longer than a second.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <votess/progress.hpp>
#include <votess/votess.hpp>

#include "failure.hpp"
#include "interrupt.hpp"

namespace clvotess {

class Progress {
public:
    using Clock = std::chrono::steady_clock;

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

// Returns work(), whose calls of the library take no callback. Also shows the bar, and stops them after a signal.
template <class Work>
auto run_watched(bool quiet, Progress::Clock::time_point run_began, const Work& work) {
    Progress progress(!quiet, run_began);
    return run_stoppable(progress, [&work](const votess::ProgressCallback& callback) {
        const votess::ProgressScope scope(callback);
        return work();
    });
}

// Returns the exit code for an error of the library.
[[nodiscard]] inline int exit_code_of(votess::ErrorCode code) {
    const bool users = code == votess::ErrorCode::invalid_argument || code == votess::ErrorCode::unsupported;
    return users ? exit_code::bad_input : exit_code::runtime_failure;
}

}  // namespace clvotess

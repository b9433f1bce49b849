// A bar on stderr, drawn only when a person is there to see it and the run lasts over a second.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <votess/votess.hpp>

#include "interrupt.hpp"

namespace clvotess {

class Progress {
public:
    using Clock = std::chrono::steady_clock;

    Progress(bool enabled, Clock::time_point run_began);  // not enabled: the run is quiet
    ~Progress();                                          // wipes the bar
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void show(double fraction);
    // What is being done, behind the bar from now on.
    void name(std::string stage) { stage_ = std::move(stage); }
    // A line of its own, unless the run is quiet.
    void say(const std::string& line);

private:
    bool quiet_;
    bool enabled_;
    bool drawn_ = false;
    Clock::time_point run_began_;
    std::string stage_;
};

// Returns work(callback), whose callback is for the library. Throws Interrupted when a signal came.
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

}  // namespace clvotess

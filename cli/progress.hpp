// A bar on stderr, drawn only when a person is there to see it and the run lasts over a second.
#pragma once

#include <chrono>

namespace clvotess {

class Progress {
public:
    using Clock = std::chrono::steady_clock;

    Progress(bool enabled, Clock::time_point run_began);
    ~Progress();  // wipes the bar
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void show(double fraction);

private:
    bool enabled_;
    bool drawn_ = false;
    Clock::time_point run_began_;
};

}  // namespace clvotess

// A bar on stderr, drawn only when a person is there to see it and the run lasts over a second.
#pragma once

#include <chrono>
#include <string>
#include <utility>

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

}  // namespace clvotess

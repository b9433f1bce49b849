// The progress of a stream: stages one after the other, each a share of the whole.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "core/progress.hpp"
#include "core/stage_clock.hpp"
#include "input/settled.hpp"

namespace votess::stream {

class Stages {
public:
    explicit Stages(const Execution& how) : log_(how.log), progress_(how.progress) {}

    void log(const std::string& text) const {
        if (log_ && !text.empty()) log_(text);
    }
    void begin(StageClock::Stage stage, double end, const std::string& text) {
        clock_.enter(stage);
        share_ = {share_.end, end};
        log(text);
        progress_.report(share_.begin);
    }
    // Throws when the user stops the run.
    void at(std::uint64_t done, std::uint64_t total) { Progress::require(progress_.going_on(share_.at(done, total))); }
    // Returns a callback for one of several runs within the stage.
    [[nodiscard]] ProgressCallback within(std::size_t number, std::size_t count) {
        return progress_.within({share_.at(number, count), share_.at(number + 1, count)});
    }
    void end() { progress_.report(1); }
    [[nodiscard]] StageSeconds seconds() { return clock_.seconds(); }

private:
    LogCallback log_;
    Progress progress_;
    StageClock clock_;
    Share share_{0, 0};
};

}  // namespace votess::stream

// Seconds of the stages of a run. One of them is always under way.
#pragma once

#include <chrono>
#include <utility>

#include "votess/votess.hpp"

namespace votess {

class StageClock {
public:
    using Stage = double StageSeconds::*;

    // Ends the present stage and begins another. Returns the one that ended. The first stage is upload.
    Stage enter(Stage next) {
        const auto now = std::chrono::steady_clock::now();
        seconds_.*stage_ += std::chrono::duration<double>(now - begin_).count();
        begin_ = now;
        return std::exchange(stage_, next);
    }
    // Enters a stage within another one, to which the clock returns at the end of the scope.
    class Within {
    public:
        Within(StageClock& clock, Stage stage) : clock_(clock), outer_(clock.enter(stage)) {}
        ~Within() { clock_.enter(outer_); }
        Within(const Within&) = delete;
        Within& operator=(const Within&) = delete;

    private:
        StageClock& clock_;
        Stage outer_;
    };
    // Divides the time of clip among the stages that a device ran meanwhile, by the seconds that each took.
    void share_clip(double knn, double clip, double download) {
        enter(stage_);
        const double all = knn + clip + download, shared = seconds_.clip;
        if (!(all > 0)) return;
        seconds_.knn += shared * knn / all;
        seconds_.clip = shared * clip / all;
        seconds_.download += shared * download / all;
    }
    // Returns the seconds up to now.
    [[nodiscard]] StageSeconds seconds() {
        enter(stage_);
        const StageSeconds& s = seconds_;
        seconds_.total = s.open + s.upload + s.sort + s.knn + s.clip + s.fallback + s.download;
        return seconds_;
    }

private:
    StageSeconds seconds_;
    Stage stage_ = &StageSeconds::upload;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace votess

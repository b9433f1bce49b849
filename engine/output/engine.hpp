// What every engine does with a job.
#pragma once

#include "core/stage_clock.hpp"
#include "input/job.hpp"
#include "result/result.hpp"

namespace votess {

class Engine {
public:
    virtual ~Engine() = default;
    // Goes through the stages upload, sort, knn, clip, fallback, download, and enters each on the clock. Fills the
    // result except its seconds. After an error the next run starts afresh.
    virtual void run(const Job& job, StageClock& clock, detail::Result& result) = 0;
};

}  // namespace votess

// The CPU engine: every cell by the exact clipper, on a thread pool.
#pragma once

#include "core/stage_clock.hpp"
#include "cpu/cpu_clipper.hpp"
#include "output/result_builder.hpp"

namespace votess::cpu {

class CpuEngine {
public:
    // The clipper and its threads may serve another engine between runs.
    explicit CpuEngine(CpuClipper& clipper) : clipper_(clipper) {}

    // Goes through the stages upload, sort, knn, clip, fallback, download, and enters each on the clock. Fills the
    // result except its seconds. After an error the next run starts afresh.
    void run(const Job& job, StageClock& clock, detail::Result& result);

private:
    // Tests the kept cells and makes those that do not hold. Returns false if all must be made.
    [[nodiscard]] bool clip_kept(const Job& job, StageClock& clock);
    // Makes all cells. plan: which of them to store.
    void clip_all(const Job& job, KeptCells::Plan plan, StageClock& clock);
    void lend(const Job& job);

    KeptCells kept_;
    CpuClipper& clipper_;
    ResultBuilder result_;
};

}  // namespace votess::cpu

// The CPU engine: every cell by the exact clipper, on a thread pool.
#pragma once

#include "cpu/cpu_clipper.hpp"
#include "output/engine.hpp"
#include "output/result_builder.hpp"

namespace votess::cpu {

class CpuEngine : public Engine {
public:
    // The clipper and its threads may serve another engine between the runs of this one.
    explicit CpuEngine(CpuClipper& clipper) : clipper_(clipper) {}

    void run(const Job& job, StageClock& clock, detail::Result& result) override;

private:
    CpuClipper& clipper_;
    ResultBuilder result_;
};

}  // namespace votess::cpu

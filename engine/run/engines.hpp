// The engines of a Tessellator. A job runs on one of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/stage_clock.hpp"
#include "input/job.hpp"
#include "result/result.hpp"

namespace votess {

namespace gpu {
class GpuEngine;
}

class Engines {
public:
    Engines();
    ~Engines();
    Engines(const Engines&) = delete;
    Engines& operator=(const Engines&) = delete;

    // Runs the job on the device that its options name. With "auto" the CPU runs small jobs, jobs that no device clips,
    // and jobs for which there is no GPU or the GPU fails. Throws `unsupported` with the reason for any other device
    // that cannot run it. Fills the result except its seconds.
    void run(const Job& job, StageClock& clock, detail::Result& result);
    // Makes the pool of so many threads, 0 = one for each processor, unless it exists.
    [[nodiscard]] ThreadPool& pool_of(unsigned threads);
    [[nodiscard]] Snapshot& snapshot();
    // For tests: the engine that a device name means, until it fails.
    void put(const std::string& device, std::unique_ptr<gpu::GpuEngine> engine);

    static std::vector<DeviceInfo> devices();

private:
    struct State;
    std::unique_ptr<State> state_;
};

// Checks the seeds of a run in a region with ends and runs it. arrays: memory of an earlier result to use again.
detail::Result run_on(Engines& engines, Settled run, detail::Result arrays = {});

}  // namespace votess

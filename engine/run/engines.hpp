// The engines of a Tessellator, and which of them runs a job.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "output/engine.hpp"

namespace votess {

class Engines {
public:
    Engines();
    ~Engines();
    Engines(const Engines&) = delete;
    Engines& operator=(const Engines&) = delete;

    // Returns the engine that the job's options name, and counts the time that opening a device takes; of "auto" the
    // CPU's, too, where a GPU would hand every cell to it. Throws `unsupported` with the reason when it cannot be had.
    Engine& choose(const Job& job, StageClock& clock);
    Engine& cpu();
    // Copies points with this number of threads, see input/snapshot.hpp.
    Points take(const Points& points, unsigned threads);
    [[nodiscard]] Snapshot& snapshot();
    // The next choice of a GPU opens it anew.
    void forget_gpu();
    // For tests: the engine that a device name stands for, until it is forgotten.
    void put(const std::string& device, std::unique_ptr<Engine> engine);

    static std::vector<DeviceInfo> devices();

private:
    struct State;
    std::unique_ptr<State> state_;
};

// Checks the input and runs it on the engine that the options name; with "auto" the CPU takes over when that one fails.
// arrays: memory of an earlier result to use again.
detail::Result run_on(Engines& engines, const Points& points, const Options& options, detail::Result arrays = {});

}  // namespace votess

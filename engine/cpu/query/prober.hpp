// The cells that queries would have, each as if it alone were added to the seeds.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cpu/clip/cell_builder.hpp"
#include "cpu/clip/cell_writer.hpp"
#include "cpu/probe.hpp"
#include "cpu/walk/star.hpp"

namespace votess::cpu {

// One per thread. The seeds and all that belongs to them stay with the caller.
class Prober {
public:
    Prober(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels);

    // job: its points are the queries.
    void begin_job(const Job& job, const StarKernels& kernels, ResultBuilder& out);
    // probes: along a curve through space; cells: their numbers, which stay as they are until the result is finished;
    // near: a group of seeds near the first. duplicate_of: by query, the seed that lies where it does is written there.
    void run(std::span<const Probe> probes, std::span<const std::int32_t> cells, std::size_t near,
             std::span<std::int32_t> duplicate_of);
    [[nodiscard]] const CellCounters& counters() const { return writer_.counters(); }

private:
    [[nodiscard]] std::size_t look_around(std::span<const Probe> probes);
    void clip(const Probe& probe, std::int32_t cell, std::span<std::int32_t> duplicate_of);

    const SortedSeeds& seeds_;
    CellBuilder builder_;
    std::unique_ptr<Star> star_;
    CellWriter writer_;
    CellFaces faces_;
    bool measure_ = false;
};

}  // namespace votess::cpu

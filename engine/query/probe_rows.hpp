// Cells of probes as the rows of a result.
#pragma once

#include <span>

#include "output/cell_writer.hpp"
#include "query/prober.hpp"

namespace votess::cpu {

// One per thread.
class ProbeRows final : public ProbeSink {
public:
    explicit ProbeRows(const SortedSeeds& seeds) : seeds_(seeds), writer_(seeds) {}

    // job: its points are the queries. duplicate_of: by query, where the seed at its place is written.
    void begin_job(const Job& job, const StarKernels& kernels, std::span<std::int32_t> duplicate_of,
                   ResultBuilder& out) {
        writer_.begin_job(job, kernels, {}, out);
        duplicate_of_ = duplicate_of;
    }
    // The numbers of the queries of a run, which stay as they are until the result is finished.
    void begin_run(std::span<const Probe> probes, std::span<const std::int32_t> queries) {
        probes_ = probes;
        queries_ = queries;
        writer_.begin_stretch();
    }
    void end_run() { writer_.end_block(queries_); }
    [[nodiscard]] const CellCounters& counters() const { return writer_.counters(); }

    bool take(std::size_t k, Star& star) override { return writer_.write(query(k), probes_[k], star); }
    void take(std::size_t k, Cell& cell) override { writer_.write(query(k), probes_[k], cell); }
    bool taken(std::size_t k, std::size_t seed) override {
        if (!seeds_.weights.empty() && seeds_.weights[seed] > probes_[k].weight) {
            writer_.write_none(query(k), CellStatus::empty);
            return false;
        }
        duplicate_of_[query(k)] = seeds_.input[seed];
        return true;
    }
    void take_seed(std::size_t k, std::size_t seed, Cell& cell) override { writer_.write(query(k), seed, cell); }

private:
    [[nodiscard]] std::size_t query(std::size_t k) const { return static_cast<std::size_t>(queries_[k]); }

    const SortedSeeds& seeds_;
    CellWriter writer_;
    std::span<const Probe> probes_;
    std::span<const std::int32_t> queries_;
    std::span<std::int32_t> duplicate_of_;
};

}  // namespace votess::cpu

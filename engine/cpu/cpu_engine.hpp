// The CPU engine: the six stages on a thread pool.
#pragma once

#include <atomic>
#include <optional>

#include "cpu/search.hpp"
#include "cpu/sort.hpp"
#include "cpu/thread_pool.hpp"
#include "engine.hpp"

namespace votess::cpu {

class CpuEngine : public Engine {
public:
    void upload(const Job& job) override;
    void sort() override;
    void knn() override;   // the search structure; candidates are pulled while clipping
    void clip() override;  // decides uncertain signs exactly on the spot
    void fallback() override;
    void download(detail::Result& result) override;

private:
    struct Counters {
        std::uint64_t faces = 0, exact_cells = 0;
    };
    struct Scratch {
        std::vector<std::int32_t> planes, row;
        CellFaces faces;
    };

    void clip_seed(std::size_t seed, CellBuilder& builder, Scratch& scratch, std::vector<std::int32_t>& rows,
                   Counters& counters);
    void finish_stats(detail::Result& result) const;

    std::optional<ThreadPool> pool_;
    Job job_;
    SortedSeeds seeds_;
    Hierarchy hierarchy_;
    detail::Result result_;
    std::vector<std::vector<std::int32_t>> rows_;  // per block of sorted seeds, concatenated
    std::vector<Counters> counters_;               // per block
};

}  // namespace votess::cpu

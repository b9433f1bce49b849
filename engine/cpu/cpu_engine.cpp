#include "cpu/cpu_engine.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "input/snapshot.hpp"

namespace votess::cpu {
namespace {

// What verify() needs to know about the seeds that have no row.
std::shared_ptr<const detail::AllSeeds> seeds_around(const Job& job, std::span<const std::int32_t> duplicate_of) {
    auto seeds = std::make_shared<detail::AllSeeds>();
    seeds->count = job.points.count();
    seeds->status = job.outside;
    if (!duplicate_of.empty()) seeds->status.resize(seeds->count, CellStatus::certified);
    for (std::size_t i = 0; i < duplicate_of.size(); ++i)
        if (duplicate_of[i] >= 0) seeds->status[i] = CellStatus::duplicate;
    seeds->weights = job.domain->weights;
    for (double& weight : seeds->weights) weight = weight / job.scale / job.scale;
    return seeds;
}

}  // namespace

// The stage fallback is empty, because exact arithmetic decides every sign at once.
void CpuEngine::run(const Job& job, StageClock& clock, detail::Result& result) {
    clipper_.begin(job);
    Progress& progress = clipper_.progress();
    const Stoppable stoppable(progress);
    progress.report(0);
    clock.enter(&StageSeconds::sort);
    clipper_.sort();
    clock.enter(&StageSeconds::knn);  // the search structure; candidates are searched while clipping
    clipper_.build_search();
    clock.enter(&StageSeconds::clip);
    result_.begin(job, clipper_.pool());
    // Periodic domains need the rounding errors of wrapped coordinates, and a mesh needs seeds in input order.
    if (job.snapshot != nullptr && !job.domain->is_periodic() && !job.want.vertices)
        result_.lend(job.snapshot->memory());
    clipper_.lend_scratch(result_);
    result_.touch(1, 0, clipper_.pool());
    if (job.only)
        clipper_.clip_only(result_, clipping);
    else
        clipper_.clip_all(result_, clipping);
    clock.enter(&StageSeconds::download);
    clipper_.set_empty(result_);
    std::span<const std::int32_t> duplicate_of = clipper_.duplicate_of();
    std::vector<std::int32_t> of_rows;
    if (job.only && !duplicate_of.empty()) {
        for (const std::int32_t id : job.only->ids()) of_rows.push_back(duplicate_of[static_cast<std::size_t>(id)]);
        if (std::ranges::all_of(of_rows, [](std::int32_t of) { return of < 0; })) of_rows.clear();
        duplicate_of = of_rows;
    }
    result_.set_duplicates(duplicate_of, clipper_.pool());
    auto all_seeds = job.only ? seeds_around(job, clipper_.duplicate_of()) : nullptr;
    clipper_.lend_seeds(result_);
    result_.finish(result, clipper_.pool());
    result.all_seeds = std::move(all_seeds);
    result.stats.device = "cpu";
    progress.report(1);
    clipper_.end();
}

}  // namespace votess::cpu

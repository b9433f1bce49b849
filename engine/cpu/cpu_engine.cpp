#include "cpu/cpu_engine.hpp"

#include <algorithm>
#include <vector>

#include "input/snapshot.hpp"

namespace votess::cpu {

// The stage fallback is empty, because exact arithmetic decides every sign at once.
void CpuEngine::run(const Job& job, StageClock& clock, detail::Result& result) {
    clipper_.begin(job);
    Progress& progress = clipper_.progress();
    const Stoppable stoppable(progress);
    progress.report(0);
    clock.enter(&StageSeconds::sort);
    clipper_.sort();
    // Periodic domains need the rounding errors of wrapped coordinates, and a mesh needs seeds in input order.
    if (job.snapshot != nullptr && !job.domain->is_periodic() && !job.options.want.vertices)
        job.snapshot->release_pages();
    clock.enter(&StageSeconds::knn);  // the search structure; candidates are searched while clipping
    clipper_.build_search();
    clock.enter(&StageSeconds::clip);
    result_.begin(job, clipper_.pool());
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
    clipper_.release_pages();
    result_.finish(result, clipper_.pool());
    result.stats.device = "cpu";
    progress.report(1);
    clipper_.end();
}

}  // namespace votess::cpu

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

void CpuEngine::lend(const Job& job) {
    // A mesh needs seeds in input order.
    if (job.snapshot != nullptr && !clipper_.reads_points() && !job.want.vertices) result_.lend(job.snapshot->memory());
    clipper_.lend_scratch(result_);
    result_.release_spare();
    result_.touch(1, 0, clipper_.pool());
}

bool CpuEngine::clip_kept(const Job& job, StageClock& clock) {
    clipper_.sort(kept_.order());
    kept_.begin(KeptCells::Plan::repair, job, clipper_.sorted(), clipper_.pool());
    clock.enter(&StageSeconds::clip);
    result_.begin(job, clipper_.pool());
    clipper_.keep(&kept_);
    const bool kept = clipper_.clip_kept(result_, clipping, [&] { lend(job); });
    clipper_.keep(nullptr);
    if (kept) kept_.commit();
    return kept;
}

void CpuEngine::clip_all(const Job& job, KeptCells::Plan plan, StageClock& clock) {
    using Plan = KeptCells::Plan;
    clock.enter(&StageSeconds::sort);
    // Rows do not depend on it, but last digits of vertices do, which are those of a run that follows.
    using Keep = CpuClipper::Keep;
    clipper_.sort({}, job.want.vertices ? Keep::all : plan == Plan::none ? Keep::unburied : Keep::all_unless_most);
    clock.enter(&StageSeconds::clip);
    result_.begin(job, clipper_.pool());
    lend(job);                        // before the search structure takes more memory
    clock.enter(&StageSeconds::knn);  // the search structure; candidates are searched while clipping
    clipper_.build_search();
    clock.enter(&StageSeconds::clip);
    if (plan != Plan::none && !clipper_.all_differ()) {
        kept_.clear();
        plan = Plan::none;
    }
    const auto store = [&] {
        kept_.begin(plan, job, clipper_.sorted(), clipper_.pool());
        clipper_.keep(&kept_);
    };
    if (plan == Plan::record) store();
    if (job.only)
        clipper_.clip_only(result_, clipping);
    else
        clipper_.clip_all(result_, clipping);
    if (plan == Plan::sample) {
        store();
        clipper_.keep_sample(result_);
    }
    clipper_.keep(nullptr);
    if (plan != Plan::none) kept_.commit();
}

// The stage fallback is empty, because exact arithmetic decides every sign at once.
void CpuEngine::run(const Job& job, StageClock& clock, detail::Result& result) {
    clipper_.begin(job);
    Progress& progress = clipper_.progress();
    const Stoppable stoppable(progress);
    progress.report(0);
    clock.enter(&StageSeconds::sort);
    using Plan = KeptCells::Plan;
    Plan plan = Plan::none;
    if (!job.follow)
        kept_.clear();
    else if (KeptCells::follows(job))
        plan = kept_.plan(job, clipper_.instructions());
    if (plan == Plan::repair && !clip_kept(job, clock)) plan = Plan::sample;
    if (plan != Plan::repair) clip_all(job, plan, clock);
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
    if (plan != Plan::none && plan != Plan::sample && !kept_.rows().are_of(result.status.size(), result.lists_walls) &&
        job.want.neighbors && result.least_face == 0)
        kept_.rows().store(result.indptr, result.indices, result.shifts, result.lists_walls);
    result.all_seeds = std::move(all_seeds);
    result.stats.device = "cpu";
    clipper_.end();
}

}  // namespace votess::cpu

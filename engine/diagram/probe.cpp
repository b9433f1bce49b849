// Cells of probes as a result.
#include <algorithm>

#include "core/progress.hpp"
#include "core/stage_clock.hpp"
#include "diagram/diagram_state.hpp"
#include "input/implied_wants.hpp"

namespace votess::detail {

Tessellation probe(DiagramState& state, std::span<const double> x, const ProbeOptions& options) {
    const Queries queries = check_queries(state, x, options.weights, options.radii);
    const CallGuard turn(state);
    StageClock clock;
    Options wanted;
    wanted.want = options.want;
    Job job = state.job;
    job.points = {queries.x, {}};
    job.options.want = with_implied(wanted);
    job.options.list_walls = options.list_walls || options.want.faces;
    job.outside.clear();
    job.probes_of = static_cast<std::int32_t>(state.points.size() / 3);
    ThreadPool& pool = state.clipper.pool();
    state.result.begin(job, pool);
    std::vector<std::int32_t> duplicate_of;
    lengthen(duplicate_of, queries.count(), -1);
    const cpu::StarKernels& kernels = cpu::star_kernels(cpu::find_kernels(job.options.instructions)->name);
    make_searchers(state);
    for (DiagramState::Searcher& searcher : state.searchers) {
        searcher.prober.begin_job(*job.domain, cpu::kept_for(job.options.want));
        searcher.rows.begin_job(job, kernels, duplicate_of, state.result);
    }
    clock.enter(&StageSeconds::clip);
    for_queries(state, queries, [&](DiagramState::Searcher& searcher, std::size_t begin, std::size_t end) {
        std::uint64_t outside = 0;
        sort_queries(job, searcher, queries, begin, end, [&](std::size_t i) {
            state.result.set_empty(i, CellStatus::outside);
            ++outside;
        });
        state.result.count({.empty_cells = outside});
        for_runs(job, searcher, queries, begin, state.result.allocate_cells(searcher.order.size()),
                 [&](std::span<const std::int32_t> numbers, std::size_t near) {
                     searcher.rows.begin_run(searcher.probes, numbers);
                     searcher.prober.run(searcher.probes, near, searcher.rows);
                     searcher.rows.end_run();
                 });
    });
    for (const DiagramState::Searcher& searcher : state.searchers) state.result.count(searcher.rows.counters());
    clock.enter(&StageSeconds::download);
    if (std::ranges::any_of(duplicate_of, [](std::int32_t seed) { return seed >= 0; }))
        state.result.set_duplicates(duplicate_of, pool, true);
    auto result = std::make_shared<Result>();
    state.result.finish(*result, pool);
    result->stats.device = "cpu";
    result->stats.threads = pool.size();
    result->stats.seconds = clock.seconds();
    return Tessellation(std::move(result));
}

}  // namespace votess::detail

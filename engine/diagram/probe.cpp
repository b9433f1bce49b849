// Cells of probes as a result.
#include <algorithm>

#include "core/progress.hpp"
#include "core/stage_clock.hpp"
#include "diagram/diagram_state.hpp"
#include "input/settle.hpp"
#include "result/arrays.hpp"
#include "solid/run_in_mesh.hpp"
#include "unbounded/open_cells.hpp"

namespace votess::detail {

namespace {

Result cells_of_probes(DiagramState& state, std::vector<double> x, const ProbeOptions& options) {
    const Queries queries = check_queries(state, std::move(x), options.weights, options.radii);
    const CallGuard turn(state);
    StageClock clock;
    Job job = state.job;
    job.points = {queries.x, {}};
    job.want = with_implied(options.want);
    job.list_walls = options.list_walls || options.want.faces;
    job.outside.clear();
    job.probes_of = static_cast<std::int32_t>(state.points.size() / 3);
    ThreadPool& pool = state.clipper.pool();
    state.result.begin(job, pool);
    std::vector<std::int32_t> duplicate_of;
    lengthen(duplicate_of, queries.count(), -1);
    const cpu::StarKernels& kernels = cpu::star_kernels(cpu::find_kernels(job.instructions)->name);
    make_searchers(state);
    for (DiagramState::Searcher& searcher : state.searchers) {
        searcher.prober.begin_job(*job.domain, cpu::kept_for(job.want));
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
    Result result;
    state.result.finish(result, pool);
    result.stats.device = "cpu";
    result.stats.threads = pool.size();
    result.stats.seconds = clock.seconds();
    return result;
}

// In a domain without end, cells that reach the walls of the near box are made again in the far one. Where seeds and
// query are flat, that one is thin.
Result endless_cells(DiagramState& state, const std::vector<double>& x, const ProbeOptions& options) {
    const Want want = with_implied(options.want);
    ProbeOptions asked = options;
    asked.list_walls = true;
    asked.want = want;
    asked.want.neighbors = true;
    asked.want.faces |= want.areas || want.counts || want.vertices;
    Result near = cells_of_probes(state, x, asked);
    std::vector<bool> taken(near.status.size()), taken_flat(taken.size());
    const auto is_end = [&](std::int32_t id) { return state.endless_sides.has(id); };
    for (std::size_t q = 0; q < taken.size(); ++q) {
        if (near.status[q] != CellStatus::outside && near.status[q] != CellStatus::empty && !lists_end(near, q, is_end))
            continue;
        const bool flat = state.flat_ends && state.flat_ends->holds({x[3 * q], x[3 * q + 1], x[3 * q + 2]});
        (flat ? taken_flat : taken)[q] = true;
    }
    const Region& domain = state.endless->region();
    const auto take = [&](const std::vector<bool>& of_far, const auto& state_beyond) {
        std::vector<std::int32_t> rows;
        for (std::size_t q = 0; q < of_far.size(); ++q)
            if (of_far[q]) rows.push_back(static_cast<std::int32_t>(q));
        Result far;
        if (!rows.empty()) {
            const std::vector<double> places = some_of(x, rows, 3), weights = some_of(options.weights, rows, 1),
                                      radii = some_of(options.radii, rows, 1);
            asked.weights = weights;
            asked.radii = radii;
            const Box ends = ends_beyond(state, places, votess::weights_of(weights, radii));
            far = cells_of_probes(*state_beyond(state, ends), places, asked);
            open_cells(far, domain);
        }
        return join_cells(std::move(near), far, rows, of_far, {}, domain);
    };
    if (std::ranges::find(taken_flat, true) != taken_flat.end()) near = take(taken_flat, flat_state);
    near = take(taken, far_state);
    keep_wanted(near, want, options.list_walls || want.faces);
    return near;
}

Result whole_cells(DiagramState& state, std::vector<double> x, const ProbeOptions& options) {
    return state.endless ? endless_cells(state, x, options) : cells_of_probes(state, std::move(x), options);
}

// The parts of the cells in the mesh.
Result cells_in_mesh(DiagramState& state, const std::vector<double>& x, const ProbeOptions& options) {
    // Read once, see input/snapshot.hpp.
    const std::vector<double> weights(options.weights.begin(), options.weights.end()),
        radii(options.radii.begin(), options.radii.end());
    ProbeOptions asked = options;
    asked.want = solid::want_of_probes(options.want);
    asked.list_walls = false;
    asked.weights = weights;
    asked.radii = radii;
    Result whole = whole_cells(state, x, asked);
    Job job = state.job;
    job.probes_of = static_cast<std::int32_t>(state.points.size() / 3);
    const Queries queries = check_queries(state, x, weights, radii);
    return solid::cut_probes(std::move(whole), x, queries.weights, state.inside->mesh(), job, options.want);
}

}  // namespace

Result probe(DiagramState& state, std::vector<double> x, const ProbeOptions& options) {
    return state.inside ? cells_in_mesh(state, x, options) : whole_cells(state, std::move(x), options);
}

}  // namespace votess::detail

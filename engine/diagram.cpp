#include "votess/diagram.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>

#include "core/ceil.hpp"
#include "core/stage_clock.hpp"
#include "core/text.hpp"
#include "cpu/cpu_clipper.hpp"
#include "cpu/query/locator.hpp"
#include "cpu/query/prober.hpp"
#include "cpu/sort/hilbert.hpp"
#include "input/implied_wants.hpp"
#include "input/options.hpp"
#include "result/result_builder.hpp"

namespace votess {

namespace detail {

// What never changes, and the threads and searches of one call after the other.
struct DiagramState {
    std::vector<double> points;
    Job job;
    cpu::CpuClipper clipper;

    // What a thread needs.
    struct Searcher {
        cpu::Locator locator;
        cpu::Prober prober;
        // The queries taken at once: by number from the first, and sorted along a curve.
        std::vector<cpu::Place> places;
        std::vector<std::uint64_t> order;
        std::vector<cpu::Probe> probes;
    };
    std::mutex at_work;
    std::deque<Searcher> searchers;
    ResultBuilder result;
};

}  // namespace detail

namespace {

using detail::DiagramState;

// Queries that one thread takes at once and sorts along a Hilbert curve: neighbors in time are neighbors in space.
constexpr std::size_t most_taken = 65536, fewest_taken = 256, shares_of_thread = 4;
constexpr std::size_t most_probed = 1024;  // in one run of a walk

// A failure to get memory as an Error.
template <class Work>
auto with_memory(const Work& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, "out of memory: take fewer seeds, or ask with fewer queries at once");
    }
}

std::shared_ptr<DiagramState> make_state(std::span<const double> points, const Options& options) {
    if (options.device != "cpu" && options.device != "auto")
        throw Error(ErrorCode::unsupported,
                    "device '" + options.device + "': a Diagram is asked on the CPU, give cpu or auto");
    if (options.min_face != 0 || options.min_area != 0)
        throw Error(ErrorCode::invalid_argument,
                    "min_face and min_area drop faces of a result: a Diagram has whole cells, leave them out");
    auto state = std::make_shared<DiagramState>();
    state->points.assign(points.begin(), points.end());
    state->job = validate({state->points, {}}, options);
    state->job.options.progress = {};
    state->job.options.weights = state->job.options.radii = {};  // which the caller keeps; the domain has them
    state->clipper.begin(state->job);
    state->clipper.prepare();
    return state;
}

// The query times the scale of the job. Its number is for messages.
exact::Point scaled(const Job& job, std::span<const double> queries, std::size_t number) {
    exact::Point x;
    for (std::size_t k = 0; k < 3; ++k) {
        const double given = queries[3 * number + k];
        x[k] = given * job.scale;
        if (std::isfinite(x[k]) && x[k] / job.scale == given) continue;
        const std::string what = "query " + std::to_string(number) + ": coordinate " + votess::number(given);
        if (!std::isfinite(given)) throw Error(ErrorCode::invalid_argument, what + " is not finite");
        throw Error(ErrorCode::unsupported,
                    what + " is too large or too small beside the box to be represented at one scale");
    }
    return x;
}

// Along a Hilbert curve through the box.
std::uint32_t key_of(const Box& box, const exact::Point& x) {
    std::array<std::uint32_t, 3> at;
    constexpr double blocks = 1 << cpu::hilbert_levels;
    for (std::size_t k = 0; k < 3; ++k) {
        const double along = (x[k] - box.lower[k]) / (box.upper[k] - box.lower[k]) * blocks;
        at[k] = static_cast<std::uint32_t>(std::clamp(along, 0.0, blocks - 1));
    }
    return cpu::hilbert_index(at[0], at[1], at[2]);
}

// The queries of a call, and those of them that a thread takes at once.
struct Queries {
    std::span<const double> x;
    [[nodiscard]] std::size_t count() const { return x.size() / 3; }
};

// Places the queries from `begin` on and sorts those inside the domain; calls leave_out for the others.
template <class LeaveOut>
void sort(const Job& job, DiagramState::Searcher& searcher, const Queries& queries, std::size_t begin, std::size_t end,
          LeaveOut leave_out) {
    searcher.places.resize(end - begin);
    searcher.order.clear();
    for (std::size_t i = begin; i < end; ++i) {
        const auto place = searcher.locator.place(scaled(job, queries.x, i), i);
        if (!place) {
            leave_out(i);
            continue;
        }
        searcher.places[i - begin] = *place;
        searcher.order.push_back(std::uint64_t{key_of(job.domain->box, place->at)} << 32 | (i - begin));
    }
    std::ranges::sort(searcher.order);
}

void make_searchers(DiagramState& state) {
    const cpu::SortedSeeds& seeds = state.clipper.seeds();
    const cpu::Hierarchy& hierarchy = state.clipper.hierarchy();
    const cpu::Kernels& kernels = *cpu::find_kernels(state.job.options.instructions);
    while (state.searchers.size() < state.clipper.pool().size())
        state.searchers.push_back({{state.job, seeds, hierarchy}, {seeds, hierarchy, kernels}, {}, {}, {}});
}

// task(searcher, begin, end) for all queries, on all threads.
template <class Task>
void for_queries(DiagramState& state, const Queries& queries, Task task) {
    ThreadPool& pool = state.clipper.pool();
    make_searchers(state);
    const std::size_t count = queries.count();
    const std::size_t taken = std::clamp(count / (shares_of_thread * pool.size()), fewest_taken, most_taken);
    pool.run(ceil_div(count, taken), [&](std::size_t index, unsigned worker) {
        task(state.searchers[worker], index * taken, std::min(count, (index + 1) * taken));
    });
}

std::vector<std::int32_t> locate(DiagramState& state, const Queries& queries) {
    std::vector<std::int32_t> seeds(queries.count());
    const std::scoped_lock lock(state.at_work);
    for_queries(state, queries, [&](DiagramState::Searcher& searcher, std::size_t begin, std::size_t end) {
        sort(state.job, searcher, queries, begin, end, [&](std::size_t i) { seeds[i] = -1; });
        for (const std::uint64_t key : searcher.order) {
            const auto i = static_cast<std::uint32_t>(key);
            seeds[begin + i] = searcher.locator.find(scaled(state.job, queries.x, begin + i), searcher.places[i]);
        }
    });
    return seeds;
}

// What probes write while they run.
struct ProbeRun {
    std::span<const double> weights;
    std::span<std::int32_t> duplicate_of;
    ResultBuilder& out;
};

void probe(const Job& job, DiagramState::Searcher& searcher, const Queries& queries, const ProbeRun& run,
           std::size_t begin, std::size_t end) {
    auto& [locator, prober, places, order, probes] = searcher;
    std::uint64_t outside = 0;
    sort(job, searcher, queries, begin, end, [&](std::size_t i) {
        run.out.set_empty(i, CellStatus::outside);
        ++outside;
    });
    run.out.count({.empty_cells = outside});
    const std::span<std::int32_t> cells = run.out.keep(order.size());
    for (std::size_t first = 0; first < order.size(); first += most_probed) {
        const std::size_t count = std::min(most_probed, order.size() - first);
        probes.clear();
        for (std::size_t k = first; k < first + count; ++k) {
            const auto i = static_cast<std::uint32_t>(order[k]);
            const std::size_t query = begin + i;
            probes.push_back({scaled(job, queries.x, query), places[i], run.weights.empty() ? 0 : run.weights[query]});
            cells[k] = static_cast<std::int32_t>(query);
        }
        prober.run(probes, cells.subspan(first, count), locator.group_near(probes.front().place.at), run.duplicate_of);
    }
}

Tessellation probe(DiagramState& state, const Queries& queries, const ProbeOptions& options) {
    const std::scoped_lock lock(state.at_work);
    StageClock clock;
    Options of_probes;
    of_probes.want = options.want;
    of_probes.weights = options.weights;
    of_probes.radii = options.radii;
    check_options(of_probes);
    Job job = state.job;
    job.points = {queries.x, {}};
    job.options.want = with_implied(of_probes);
    job.options.list_walls = options.list_walls || options.want.faces;
    job.outside.clear();
    job.probes_of = static_cast<std::int32_t>(state.points.size() / 3);
    const std::vector<double> weights = scaled_weights(of_probes, queries.count(), "queries", job.scale);
    if (!weights.empty() && !job.domain->has_weights())
        throw Error(ErrorCode::invalid_argument,
                    "probes have weights, but the seeds have none: give these weights too, which may be 0");
    ThreadPool& pool = state.clipper.pool();
    state.result.begin(job, pool);
    std::vector<std::int32_t> duplicate_of(queries.count(), -1);
    clock.enter(&StageSeconds::clip);
    const cpu::StarKernels& kernels = cpu::star_kernels(cpu::find_kernels(job.options.instructions)->name);
    make_searchers(state);
    for (DiagramState::Searcher& searcher : state.searchers) searcher.prober.begin_job(job, kernels, state.result);
    for_queries(state, queries, [&](DiagramState::Searcher& searcher, std::size_t begin, std::size_t end) {
        probe(job, searcher, queries, {weights, duplicate_of, state.result}, begin, end);
    });
    for (const DiagramState::Searcher& searcher : state.searchers) state.result.count(searcher.prober.counters());
    clock.enter(&StageSeconds::download);
    if (std::ranges::any_of(duplicate_of, [](std::int32_t seed) { return seed >= 0; }))
        state.result.set_duplicates(duplicate_of, pool);
    auto result = std::make_shared<detail::Result>();
    state.result.finish(*result, pool);
    result->stats.device = "cpu";
    result->stats.threads = pool.size();
    result->stats.seconds = clock.seconds();
    return Tessellation(std::move(result));
}

void check_shape(std::span<const double> queries) {
    if (queries.size() % 3 != 0)
        throw Error(ErrorCode::invalid_argument,
                    "queries hold " + std::to_string(queries.size()) +
                        " coordinates, which is not a multiple of 3: the shape must be (Q,3)");
}

}  // namespace

Diagram::Diagram() : Diagram(std::span<const double>{}) {}
Diagram::Diagram(std::span<const double> points, const Options& options)
    : state_(with_memory([&] { return make_state(points, options); })) {}

std::size_t Diagram::size() const noexcept {
    return state_->points.size() / 3;
}

std::vector<std::int32_t> Diagram::locate(std::span<const double> queries) const {
    check_shape(queries);
    return with_memory([&] { return votess::locate(*state_, {queries}); });
}

Tessellation Diagram::probe(std::span<const double> queries, const ProbeOptions& options) const {
    check_shape(queries);
    return with_memory([&] { return votess::probe(*state_, {queries}, options); });
}

}  // namespace votess

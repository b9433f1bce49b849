#include "diagram/diagram_state.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "index/hilbert.hpp"
#include "input/options.hpp"
#include "unbounded/endless_box.hpp"

namespace votess::detail {
namespace {

// Queries that one thread takes at once: neighbors in time are neighbors in space.
constexpr std::size_t max_batch = 65536, min_batch = 256, shares_of_thread = 4;
constexpr std::size_t max_probed = 1024;      // in one run of a walk
constexpr std::size_t queries_per_look = 64;  // after which the user may stop
constexpr std::chrono::milliseconds look_interval{10};

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

}  // namespace

std::unique_ptr<DiagramState> make_state(std::span<const double> points, const Options& options) {
    auto state = std::make_unique<DiagramState>();
    state->points.reserve(points.size());
    in_pieces(points.size(), [&](std::size_t begin, std::size_t end) {
        state->points.insert(state->points.end(), points.begin() + static_cast<std::ptrdiff_t>(begin),
                             points.begin() + static_cast<std::ptrdiff_t>(end));
    });
    state->job = validate({state->points, {}}, options);
    state->job.options.progress = {};
    state->job.options.weights = state->job.options.radii = {};  // which the caller keeps; the domain has them
    state->clipper.begin(state->job);
    state->clipper.prepare();
    return state;
}

std::vector<double> weights_of(const DiagramState& state) {
    std::vector<double> weights = state.job.domain->weights;
    for (double& weight : weights) weight = weight / state.job.scale / state.job.scale;
    return weights;
}

Options options_in(const DiagramState& state, const std::optional<Box>& box, std::span<const double> weights) {
    Options options = state.job.options;
    if (!options.cell) options.box = box;
    options.weights = weights;
    options.device = "cpu";
    return options;
}

namespace {

Box far_box_of(const DiagramState& state, std::span<const double> weights) {
    return far_box({state.points, {}}, weights, *state.endless);
}

// Makes the state if it is missing.
template <class Make>
DiagramState& other_state(DiagramState& state, std::unique_ptr<DiagramState>& other, Make make) {
    const std::scoped_lock lock(state.making);
    if (!other) other = make(weights_of(state));
    return *other;
}

}  // namespace

DiagramState& far_state(DiagramState& state) {
    return other_state(state, state.far, [&](const std::vector<double>& weights) {
        return make_state(state.points, options_in(state, far_box_of(state, weights), weights));
    });
}

DiagramState& hull_state(DiagramState& state) {
    return other_state(state, state.hull, [&](const std::vector<double>& weights) {
        Options options = options_in(state, state.endless, weights);
        options.want = {.neighbors = true, .volumes = false};
        options.list_walls = true;
        const Tessellation t = tessellate(state.points, options);
        std::vector<std::int32_t> open;
        for (std::size_t i = 0; i < t.size(); ++i)
            if (const auto row = t.neighbors(i); !row.empty() && row[0] < 0)
                open.push_back(static_cast<std::int32_t>(i));
        const std::vector<double> of_open = some_of(weights, open, 1);
        return make_state(some_of(state.points, open, 3), options_in(state, far_box_of(state, weights), of_open));
    });
}

DiagramState& state_around(DiagramState& state) {
    return other_state(state, state.around, [&](const std::vector<double>& weights) {
        return make_state(state.points, options_in(state, std::nullopt, weights));
    });
}

CallGuard::CallGuard(DiagramState& state) : state_(state) {
    const auto self = std::this_thread::get_id(), nobody = std::thread::id();
    std::unique_lock lock(state.mutex);
    if (state.caller == self)
        throw Error(ErrorCode::invalid_use,
                    "a callback of this Diagram's own call asks it: ask another Diagram, or after the call");
    while (!state.ended.wait_for(lock, look_interval, [&] { return state.caller == nobody; })) {
        lock.unlock();
        check_stop();
        lock.lock();
    }
    state.caller = self;
}

CallGuard::~CallGuard() {
    const std::scoped_lock lock(state_.mutex);
    state_.caller = {};
    state_.ended.notify_one();
}

Queries check_queries(const DiagramState& state, std::span<const double> x, std::span<const double> weights,
                      std::span<const double> radii) {
    if (x.size() % 3 != 0)
        throw Error(ErrorCode::invalid_argument,
                    "queries hold " + std::to_string(x.size()) +
                        " coordinates, which is not a multiple of 3: the shape must be (Q,3)");
    if (x.size() / 3 > std::numeric_limits<std::int32_t>::max())
        throw Error(ErrorCode::unsupported,
                    std::to_string(x.size() / 3) + " queries are too many at once: at most 2147483647");
    Options given;
    given.weights = weights;
    given.radii = radii;
    check_options(given);
    Queries queries{{x.begin(), x.end()}, scaled_weights(given, x.size() / 3, "queries", state.job.scale)};
    if (!queries.weights.empty() && !state.job.domain->has_weights())
        throw Error(ErrorCode::invalid_argument,
                    "queries have weights, but the seeds have none: give these weights too, which may be 0");
    return queries;
}

exact::Point scaled(const Job& job, const Queries& queries, std::size_t number) {
    exact::Point x;
    for (std::size_t k = 0; k < 3; ++k) {
        const double given = queries.x[3 * number + k];
        x[k] = given * job.scale;
        if (std::isfinite(x[k]) && x[k] / job.scale == given) continue;
        const std::string what = "query " + std::to_string(number) + ": coordinate " + votess::number(given);
        if (!std::isfinite(given)) throw Error(ErrorCode::invalid_argument, what + " is not finite");
        throw Error(ErrorCode::unsupported,
                    what + " is too large or too small beside the box to be represented at one scale");
    }
    return x;
}

void make_searchers(DiagramState& state) {
    const cpu::Kernels& kernels = *cpu::find_kernels(state.job.options.instructions);
    while (state.searchers.size() < state.clipper.pool().size())
        state.searchers.emplace_back(state.job, state.clipper.seeds(), state.clipper.hierarchy(), kernels);
}

void for_queries(DiagramState& state, const Queries& queries,
                 const std::function<void(DiagramState::Searcher&, std::size_t, std::size_t)>& task) {
    ThreadPool& pool = state.clipper.pool();
    make_searchers(state);
    const std::size_t count = queries.count();
    const std::size_t taken = std::clamp(count / (shares_of_thread * pool.size()), min_batch, max_batch);
    pool.run_stage(ceil_div(count, taken), [&](std::size_t index, unsigned worker) {
        task(state.searchers[worker], index * taken, std::min(count, (index + 1) * taken));
    });
}

void sort_queries(const Job& job, DiagramState::Searcher& searcher, const Queries& queries, std::size_t begin,
                  std::size_t end, const std::function<void(std::size_t)>& skip) {
    searcher.places.resize(end - begin);
    searcher.order.clear();
    for (std::size_t i = begin; i < end; ++i) {
        if (i % queries_per_look == 0) check_stop();
        const auto place = searcher.locator.place(scaled(job, queries, i), i);
        if (!place) {
            skip(i);
            continue;
        }
        searcher.places[i - begin] = *place;
        searcher.order.push_back(std::uint64_t{key_of(job.domain->box, place->at)} << 32 | (i - begin));
    }
    std::ranges::sort(searcher.order);
}

void for_runs(const Job& job, DiagramState::Searcher& searcher, const Queries& queries, std::size_t begin,
              std::span<std::int32_t> numbers,
              const std::function<void(std::span<const std::int32_t>, std::size_t)>& run) {
    const auto& order = searcher.order;
    auto& probes = searcher.probes;
    for (std::size_t first = 0; first < order.size(); first += max_probed) {
        const std::size_t count = std::min(max_probed, order.size() - first);
        probes.clear();
        for (std::size_t k = first; k < first + count; ++k) {
            const auto i = static_cast<std::uint32_t>(order[k]);
            const std::size_t query = begin + i;
            const double weight = queries.weights.empty() ? 0 : queries.weights[query];
            probes.push_back({scaled(job, queries, query), searcher.places[i], weight});
            numbers[k] = static_cast<std::int32_t>(query);
        }
        run(numbers.subspan(first, count), searcher.locator.group_near(probes.front().place.at));
    }
}

std::vector<double> some_of(std::span<const double> all, std::span<const std::int32_t> numbers, std::size_t each) {
    std::vector<double> some;
    if (all.empty()) return some;
    for (const std::int32_t number : numbers)
        for (std::size_t k = 0; k < each; ++k) some.push_back(all[each * static_cast<std::size_t>(number) + k]);
    return some;
}

std::vector<std::int32_t> locate(DiagramState& state, const Queries& queries) {
    std::vector<std::int32_t> seeds;
    lengthen(seeds, queries.count());
    const CallGuard turn(state);
    for_queries(state, queries, [&](DiagramState::Searcher& searcher, std::size_t begin, std::size_t end) {
        sort_queries(state.job, searcher, queries, begin, end, [&](std::size_t i) { seeds[i] = -1; });
        for (std::size_t k = 0; k < searcher.order.size(); ++k) {
            if (k % queries_per_look == 0) check_stop();
            const auto i = static_cast<std::uint32_t>(searcher.order[k]);
            seeds[begin + i] = searcher.locator.find(scaled(state.job, queries, begin + i), searcher.places[i]);
        }
    });
    if (!state.endless) return seeds;
    std::vector<std::int32_t> beyond;
    for (std::size_t q = 0; q < seeds.size(); ++q)
        if (seeds[q] < 0) beyond.push_back(static_cast<std::int32_t>(q));
    if (beyond.empty() || state.points.empty()) return seeds;
    const std::vector<std::int32_t> far = locate(far_state(state), {some_of(queries.x, beyond, 3), {}});
    for (std::size_t k = 0; k < beyond.size(); ++k) seeds[static_cast<std::size_t>(beyond[k])] = far[k];
    return seeds;
}

}  // namespace votess::detail

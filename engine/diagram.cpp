#include "votess/diagram.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>

#include "core/ceil.hpp"
#include "core/text.hpp"
#include "cpu/cpu_clipper.hpp"
#include "cpu/query/locator.hpp"
#include "cpu/sort/hilbert.hpp"
#include "input/options.hpp"

namespace votess {

namespace detail {

// What never changes, and the threads and searches of one call after the other.
struct DiagramState {
    std::vector<double> points;
    Job job;
    cpu::CpuClipper clipper;

    struct Searcher {
        cpu::Locator locator;
        // Where the queries taken at once lie; key and number of each, in the order in which they are asked.
        std::vector<cpu::Locator::Place> places;
        std::vector<std::uint64_t> order;
    };
    std::mutex at_work;
    std::deque<Searcher> searchers;
};

}  // namespace detail

namespace {

using detail::DiagramState;

// Queries that one thread takes at once and sorts along a Hilbert curve: neighbors in time are neighbors in space.
constexpr std::size_t most_taken = 65536, fewest_taken = 256, shares_of_thread = 4;

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

void locate(const Job& job, DiagramState::Searcher& searcher, std::span<const double> queries,
            std::span<std::int32_t> seeds, std::size_t begin, std::size_t end) {
    auto& [locator, places, order] = searcher;
    places.resize(end - begin);
    order.clear();
    for (std::size_t i = begin; i < end; ++i) {
        seeds[i] = -1;
        const auto place = locator.place(scaled(job, queries, i), i);
        if (!place) continue;
        places[i - begin] = *place;
        order.push_back(std::uint64_t{key_of(job.domain->box, place->at)} << 32 | (i - begin));
    }
    std::ranges::sort(order);
    for (const std::uint64_t key : order) {
        const auto i = static_cast<std::uint32_t>(key);
        seeds[begin + i] = locator.find(scaled(job, queries, begin + i), places[i]);
    }
}

std::vector<std::int32_t> locate_all(DiagramState& state, std::span<const double> queries) {
    const std::size_t count = queries.size() / 3;
    std::vector<std::int32_t> seeds(count);
    const std::scoped_lock lock(state.at_work);
    ThreadPool& pool = state.clipper.pool();
    while (state.searchers.size() < pool.size())
        state.searchers.push_back({{state.job, state.clipper.seeds(), state.clipper.hierarchy()}, {}, {}});
    const std::size_t taken = std::clamp(count / (shares_of_thread * pool.size()), fewest_taken, most_taken);
    pool.run(ceil_div(count, taken), [&](std::size_t task, unsigned worker) {
        locate(state.job, state.searchers[worker], queries, seeds, task * taken, std::min(count, (task + 1) * taken));
    });
    return seeds;
}

}  // namespace

Diagram::Diagram() : Diagram(std::span<const double>{}) {}
Diagram::Diagram(std::span<const double> points, const Options& options)
    : state_(with_memory([&] { return make_state(points, options); })) {}

std::size_t Diagram::size() const noexcept {
    return state_->points.size() / 3;
}

std::vector<std::int32_t> Diagram::locate(std::span<const double> queries) const {
    if (queries.size() % 3 != 0)
        throw Error(ErrorCode::invalid_argument,
                    "queries hold " + std::to_string(queries.size()) +
                        " coordinates, which is not a multiple of 3: the shape must be (Q,3)");
    return with_memory([&] { return locate_all(*state_, queries); });
}

}  // namespace votess

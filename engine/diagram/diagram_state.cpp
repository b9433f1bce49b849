#include "diagram/diagram_state.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/box.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "index/hilbert.hpp"
#include "input/default_box.hpp"
#include "input/settle.hpp"
#include "plane/sheet.hpp"
#include "solid/run_in_mesh.hpp"

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

namespace {

constexpr Box no_ends_of_plane{{-infinity, -infinity, 0}, {infinity, infinity, 0}};

constexpr double rounding = 0x1p-40;  // of places along the edges of a cell, over their coordinates

// Makes the state of a run in space, in a region that has ends.
std::shared_ptr<DiagramState> make_state(std::vector<double> points, Settled run) {
    auto state = std::make_shared<DiagramState>();
    state->points = std::move(points);
    run.points = {state->points, {}};
    run.progress = {};
    state->job = make_job(std::move(run));
    if (!state->job.region.cell) state->job.region.box = state->job.box;
    state->job.reports_weights = false;  // cells of probes have none
    state->clipper.begin(state->job);
    state->clipper.prepare();
    return state;
}

// Widens bounds along edges, so that they hold a place, or a box along the axes.
void include(const Edges& edges, const Vector3& x, Box& bounds) {
    votess::include(bounds, edges.along(x));
}
void include(const Edges& edges, const Box& box, Box& bounds) {
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vector3 x = box.lower;
        for (std::size_t k = 0; k < 3; ++k)
            if ((corner >> k & 1) != 0) x[k] = box.upper[k];
        include(edges, x, bounds);
    }
}

}  // namespace

std::shared_ptr<DiagramState> make_state(Settled run) {
    Region& region = run.region;
    if (!region.box && !region.cell && region.walls.empty()) region.box = region.planar ? no_ends_of_plane : all_space;
    std::vector<double> places;
    std::optional<Sheet> sheet;
    if (region.planar) {
        run = sheet.emplace(std::move(run)).take_in_space();
        places = sheet->take_points();
    } else {
        const auto& points = run.points.f64;
        places.reserve(points.size());
        in_pieces(points.size(), [&](std::size_t begin, std::size_t end) {
            places.insert(places.end(), points.begin() + static_cast<std::ptrdiff_t>(begin),
                          points.begin() + static_cast<std::ptrdiff_t>(end));
        });
    }
    std::optional<solid::ClosedMesh> mesh;
    const EndlessSides sides(region);
    if (region.mesh) {
        mesh.emplace(*region.mesh);
        if (!sides.any()) solid::check_inside(*mesh, region);
    }
    region.mesh.reset();
    std::optional<Edges> endless;
    std::optional<FlatEnds> flat_ends;
    Box ends;
    if (sides.any()) {
        endless.emplace(region);
        flat_ends.emplace(Points{places, {}}, region);
        ends = end_near(region, {places, {}}, run.weights);
        if (mesh) include(*endless, solid::default_box_around(*mesh, {places, {}}), ends);
        region = endless->with_ends(ends = endless->ends_or(ends));
    }
    std::shared_ptr<DiagramState> state = make_state(std::move(places), std::move(run));
    state->endless_sides = sides;
    state->endless = std::move(endless);
    state->ends = ends;
    if (flat_ends && flat_ends->any()) state->flat_ends = std::move(flat_ends);
    if (mesh) {
        solid::place_mesh(*mesh, state->job);
        state->inside.emplace(std::make_shared<const solid::ClosedMesh>(std::move(*mesh)), state->job.domain);
    }
    return state;
}

Weights weights_of(const DiagramState& state) {
    Weights weights{state.job.domain->weights};
    for (double& weight : weights.given) weight = weight / state.job.scale / state.job.scale;
    return weights;
}

Settled run_in(const DiagramState& state, Region region) {
    Settled run = state.job;
    run.weights = weights_of(state);
    run.region = std::move(region);
    run.device = "cpu";
    return run;
}

Box ends_with(const DiagramState& state, std::span<const double> places) {
    const Edges& edges = *state.endless;
    Box ends = state.ends;
    double largest = 0;
    for (std::size_t q = 0; 3 * q < places.size(); ++q) {
        const Vector3 x = point_of(places, q);
        include(edges, x, ends);
        for (const double c : x) largest = std::max(largest, std::abs(c));
    }
    for (std::size_t k = 0; k < 3 && edges.region().cell; ++k) {
        const double room = rounding * (largest + std::abs(ends.lower[k]) + std::abs(ends.upper[k]));
        ends.lower[k] -= room, ends.upper[k] += room;
    }
    return edges.ends_or(ends);
}

namespace {

bool holds(const Box& outer, const Box& inner) {
    for (std::size_t k = 0; k < 3; ++k)
        if (inner.lower[k] < outer.lower[k] || inner.upper[k] > outer.upper[k]) return false;
    return true;
}

}  // namespace

// Queries far out and those with many digits each widen the domain. Those with both would widen it more than any one
// does, so the two kinds have ends of their own.
Box ends_beyond(const DiagramState& state, std::span<const double> places, const Weights& weights) {
    Box ends = state.ends;
    for (const bool is_near : {true, false}) {
        std::vector<double> all = state.points;
        Weights of_all = weights_of(state);
        for (std::size_t q = 0; 3 * q < places.size(); ++q) {
            const Vector3 x = point_of(places, q), at = state.endless->along(x);
            if (holds(state.ends, {at, at}) != is_near) continue;
            all.insert(all.end(), x.begin(), x.end());
            if (!of_all.empty()) of_all.given.push_back(weights.empty() ? 0 : weights[q]);
        }
        if (all.size() == state.points.size()) continue;
        Region far = state.endless->region();
        votess::include(ends, end_far(far, {all, {}}, of_all));
    }
    return ends;
}

namespace {

// Makes the state of some seeds, none for all, between ends.
std::shared_ptr<DiagramState> between(const DiagramState& state, const std::vector<std::int32_t>* seeds,
                                      const Box& ends, const EndlessSides& sides, const FlatEnds* flat_ends = nullptr) {
    Settled run = run_in(state, state.endless->with_ends(ends));
    if (seeds != nullptr) run.weights.given = some_of(run.weights.given, *seeds, 1);
    std::vector<double> points = seeds == nullptr ? state.points : some_of(state.points, *seeds, 3);
    if (flat_ends != nullptr) flat_ends->cut(run.region);
    auto made = make_state(std::move(points), std::move(run));
    made->endless_sides = sides;
    made->ends = ends;
    return made;
}

// Returns `made`, which is made again unless it holds these ends.
std::shared_ptr<DiagramState> holding(const DiagramState& state, std::shared_ptr<DiagramState>& made,
                                      const std::vector<std::int32_t>* seeds, const Box& ends,
                                      const FlatEnds* flat_ends = nullptr) {
    if (!made || !holds(made->ends, ends)) made = between(state, seeds, ends, state.endless_sides, flat_ends);
    return made;
}

std::vector<std::int32_t> open_seeds(const DiagramState& state) {
    Settled run = run_in(state, state.endless->region());
    run.want = {.neighbors = true, .volumes = false};
    run.list_walls = true;
    const Tessellation t = tessellate(std::move(run));
    std::vector<std::int32_t> open;
    for (std::size_t i = 0; i < t.size(); ++i)
        if (state.endless_sides.any_of(t.neighbors(i))) open.push_back(static_cast<std::int32_t>(i));
    return open;
}

}  // namespace

std::shared_ptr<DiagramState> far_state(DiagramState& state, const Box& ends) {
    const std::scoped_lock lock(state.making);
    return holding(state, state.far, nullptr, ends);
}

std::shared_ptr<DiagramState> flat_state(DiagramState& state, const Box& ends) {
    const std::scoped_lock lock(state.making);
    return holding(state, state.flat, nullptr, ends, &*state.flat_ends);
}

std::shared_ptr<DiagramState> hull_state(DiagramState& state, const Box& ends) {
    const std::scoped_lock lock(state.making);
    if (!state.open) state.open = open_seeds(state);
    return holding(state, state.hull, &*state.open, ends);
}

std::shared_ptr<DiagramState> state_around(DiagramState& state) {
    const std::scoped_lock lock(state.making);
    if (state.around) return state.around;
    const Edges& edges = *state.endless;
    const Box given = edges.ends_or(all_space);
    const std::size_t count = state.points.size() / 3;
    Box bounds = empty_box;
    for (std::size_t i = 0; i < count; ++i) include(edges, point_of(state.points, i), bounds);
    for (std::size_t k = 0; k < 3; ++k)
        for (double* const x : {&bounds.lower[k], &bounds.upper[k]})
            *x = std::clamp(*x, given.lower[k], given.upper[k]);
    if (state.inside) {
        Box of_mesh = state.inside->mesh()->bounds();
        if (state.planar())
            of_mesh.lower[2] = of_mesh.upper[2] = 0;  // the height of a prism over polygons says nothing
        include(edges, of_mesh, bounds);
    }
    const std::size_t divisor = state.inside ? std::max<std::size_t>(count, 1) : count;
    const Box ends = edges.ends_or(default_box(bounds, divisor, state.planar() ? 2 : 3));
    return state.around = between(state, nullptr, ends, EndlessSides());
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

std::vector<double> in_space(const DiagramState& state, std::span<const double> vectors, const char* name) {
    const std::size_t components = state.planar() ? 2 : 3;
    if (vectors.size() % components != 0) {
        const std::string n = std::to_string(components);
        refuse(std::string(name) + " hold " + std::to_string(vectors.size()) + " coordinates, not a multiple of " + n +
               ": the shape must be (Q," + n + ")");
    }
    return components == 2 ? in_sheet({vectors, {}}) : std::vector<double>(vectors.begin(), vectors.end());
}

Queries check_queries(const DiagramState& state, std::vector<double> x, std::span<const double> weights,
                      std::span<const double> radii) {
    const std::size_t count = x.size() / 3;
    if (count > std::numeric_limits<std::int32_t>::max())
        throw Error(ErrorCode::unsupported,
                    std::to_string(count) + " queries are too many at once: at most 2147483647");
    Queries queries{std::move(x),
                    scaled_weights(votess::weights_of(weights, radii), count, "queries", state.job.scale)};
    if (state.points.empty()) queries.weights.clear();  // a cell without neighbors has no use for its weight
    if (!queries.weights.empty() && !state.job.domain->has_weights())
        refuse("queries have weights, but the seeds have none: give these weights too, which may be 0");
    return queries;
}

exact::Point scaled(const Job& job, const Queries& queries, std::size_t number) {
    exact::Point x;
    for (std::size_t k = 0; k < 3; ++k) {
        const double given = queries.x[3 * number + k];
        x[k] = given * job.scale;
        if (std::isfinite(x[k]) && x[k] / job.scale == given) continue;
        const std::string what = "query " + std::to_string(number) + ": coordinate " + votess::number(given);
        if (!std::isfinite(given)) refuse(what + " is not finite");
        throw Error(ErrorCode::unsupported,
                    what + " is too large or too small beside the box to be represented at one scale");
    }
    return x;
}

void make_searchers(DiagramState& state) {
    const cpu::Kernels& kernels = *cpu::find_kernels(state.job.instructions);
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

std::vector<std::int32_t> in_mesh(DiagramState& state, const Queries& queries) {
    std::vector<std::uint8_t> inside;
    lengthen(inside, queries.count());
    const CallGuard turn(state);
    for_queries(state, queries, [&](DiagramState::Searcher&, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (i % queries_per_look == 0) check_stop();
            inside[i] = state.inside->holds(scaled(state.job, queries, i)) ? 1 : 0;
        }
    });
    std::vector<std::int32_t> numbers;
    for (std::size_t i = 0; i < inside.size(); ++i)
        if (inside[i] != 0) numbers.push_back(static_cast<std::int32_t>(i));
    return numbers;
}

std::vector<std::int32_t> locate(DiagramState& state, const Queries& queries) {
    if (!state.inside) return locate_in_domain(state, queries);
    const std::vector<std::int32_t> numbers = in_mesh(state, queries);
    const std::vector<std::int32_t> found = locate_in_domain(state, {some_of(queries.x, numbers, 3), {}});
    std::vector<std::int32_t> seeds;
    lengthen(seeds, queries.count(), -1);
    for (std::size_t k = 0; k < numbers.size(); ++k) seeds[static_cast<std::size_t>(numbers[k])] = found[k];
    return seeds;
}

std::vector<std::int32_t> locate_in_domain(DiagramState& state, const Queries& queries) {
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
    const std::vector<double> places = some_of(queries.x, beyond, 3);
    const std::vector<std::int32_t> far = locate_in_domain(*far_state(state, ends_with(state, places)), {places, {}});
    for (std::size_t k = 0; k < beyond.size(); ++k) seeds[static_cast<std::size_t>(beyond[k])] = far[k];
    return seeds;
}

}  // namespace votess::detail

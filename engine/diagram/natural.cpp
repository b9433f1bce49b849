// Natural-neighbor coordinates, as rows or summed with values.
#include <algorithm>
#include <limits>
#include <numeric>

#include "core/errors.hpp"
#include "core/progress.hpp"
#include "diagram/diagram_state.hpp"
#include "input/settle.hpp"
#include "plane/sheet.hpp"
#include "unbounded/open_cells.hpp"

namespace votess::detail {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double share_of_cells = 0.4, share_of_graph = 0.6;  // of a call that makes the graph

// Makes the graph where it will pay: it costs about as much as dividing half as many cells as there are seeds.
bool need_graph(DiagramState& state, const Queries& queries, const NaturalOptions& options) {
    const Job& job = state.job;
    const cpu::SortedSeeds& seeds = state.clipper.seeds();
    constexpr std::size_t min_seeds = 64;
    if (options.method != NaturalMethod::sibson || job.domain->is_periodic() || job.domain->triclinic) return false;
    if (state.planar()) return false;  // all vertices of a sheet lie on its walls
    if (state.graph) return true;
    if (seeds.size() < min_seeds || queries.count() < seeds.size() / 2) return false;
    const Share stage = Stoppable::stage();
    std::vector<double> points, weights;
    if (!seeds.weights.empty()) weights.assign(seeds.weights.begin(), seeds.weights.begin() + std::ssize(seeds.input));
    points.reserve(3 * seeds.size());
    in_pieces(seeds.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s)
            for (const double place : {seeds.x[s], seeds.y[s], seeds.z[s]}) points.push_back(place / job.scale);
    });
    for (double& weight : weights) weight /= job.scale * job.scale;
    Settled run = run_in(state, job.region);
    run.points = {points, {}};
    run.weights = {weights};
    run.want = {.volumes = false, .faces = true};
    run.progress = Stoppable::within(stage.part(0, share_of_cells));
    state.graph.emplace(seeds, tessellate(std::move(run)), job.scale);
    Stoppable::enter_stage(stage.part(share_of_graph, 1));
    return true;
}

// Where cells have no coordinates: at infinity, and at walls unless the options allow those.
cpu::FieldEnds ends_of(const DiagramState& state, const NaturalOptions& options) {
    cpu::FieldEnds ends{0, !options.at_walls};
    for (std::int32_t side = 0; side < 6; ++side) {
        const std::int32_t wall = -1 - side;
        const bool of_sheet = state.planar() && Sheet::bounds(wall);
        if (state.endless_sides.has(wall) || (!options.at_walls && !of_sheet)) ends.sides |= 1u << side;
    }
    return ends;
}

// make_sink: makes the receiver of the rows of a share of the queries. Its `numbers` are those of a run.
template <class MakeSink>
void run(DiagramState& state, const Queries& queries, const NaturalOptions& options, MakeSink make_sink) {
    if (options.gradients && options.method == NaturalMethod::laplace)
        refuse("gradients are known with Sibson's coordinates: Laplace's have none across some spheres");
    NaturalOptions without_progress = options;
    without_progress.progress = nullptr;
    const CallGuard turn(state);
    const bool with_graph = need_graph(state, queries, options);
    make_searchers(state);
    for (DiagramState::Searcher& searcher : state.searchers) {
        searcher.prober.begin_job(*state.job.domain, cpu::Star::Keep::places);
        searcher.natural.begin_job(state.job, without_progress, ends_of(state, options));
    }
    for_queries(state, queries, [&](DiagramState::Searcher& searcher, std::size_t begin, std::size_t end) {
        sort_queries(state.job, searcher, queries, begin, end, [](std::size_t) {});
        std::vector<std::int32_t> numbers(searcher.order.size()), of_rest;
        auto sink = make_sink();
        const auto by_cells = [&](std::span<const cpu::Probe> probes, std::span<const std::int32_t> of_probes,
                                  std::size_t near) {
            sink.numbers = of_probes;
            searcher.natural.begin_run(probes, sink);
            searcher.prober.run(probes, near, searcher.natural);
        };
        for_runs(state.job, searcher, queries, begin, numbers,
                 [&](std::span<const std::int32_t> of_run, std::size_t near) {
                     if (!with_graph) return by_cells(searcher.probes, of_run, near);
                     sink.numbers = of_run;
                     searcher.natural.begin_run(searcher.probes, sink);
                     searcher.natural.begin_graph(*state.graph, near * cpu::group_size);
                     searcher.rest.clear();
                     of_rest.clear();
                     for (std::size_t k = 0; k < of_run.size(); ++k) {
                         if (searcher.natural.take_by_graph(k)) continue;
                         searcher.rest.push_back(searcher.probes[k]);
                         of_rest.push_back(of_run[k]);
                     }
                     if (!of_rest.empty()) by_cells(searcher.rest, of_rest, near);
                 });
    });
}

// Rows wait until all lengths are known.
struct RowSink final : cpu::NaturalSink {
    struct Rows {
        std::vector<std::int32_t> queries, seeds;
        std::vector<double> weights, gradients;
    };
    RowSink(NaturalCoordinates& out_to, Rows& rows_to, bool with_gradients)
        : out(out_to), rows(rows_to), gradients(with_gradients) {}

    void take(std::size_t k, const cpu::NaturalRow& row) override {
        out.indptr[static_cast<std::size_t>(numbers[k]) + 1] = static_cast<std::int64_t>(row.seeds.size());
        rows.queries.push_back(numbers[k]);
        rows.seeds.insert(rows.seeds.end(), row.seeds.begin(), row.seeds.end());
        rows.weights.insert(rows.weights.end(), row.weights.begin(), row.weights.end());
        for (std::size_t e = 0; e < row.seeds.size() && gradients; ++e)
            rows.gradients.insert(rows.gradients.end(), row.gradients[e].begin(), row.gradients[e].end());
    }

    NaturalCoordinates& out;
    Rows& rows;
    bool gradients;
    std::span<const std::int32_t> numbers;
};

struct SumSink final : cpu::NaturalSink {
    SumSink(Interpolated& out_to, std::vector<std::uint8_t>& known_to, std::span<const double> of_values,
            std::size_t count, bool with_gradients)
        : out(out_to), known(known_to), values(of_values), components(count), gradients(with_gradients) {}

    void take(std::size_t k, const cpu::NaturalRow& row) override {
        if (row.seeds.empty()) return;
        const auto query = static_cast<std::size_t>(numbers[k]);
        known[query] = 1;
        for (std::size_t c = 0; c < components; ++c) {
            double sum = 0;
            std::array<double, 3> slope{};
            for (std::size_t e = 0; e < row.seeds.size(); ++e) {
                const double value = values[static_cast<std::size_t>(row.seeds[e]) * components + c];
                sum += row.weights[e] * value;
                for (std::size_t i = 0; i < 3 && gradients; ++i) slope[i] += row.gradients[e][i] * value;
            }
            const std::size_t place = query * components + c;
            out.values[place] = sum;
            for (std::size_t i = 0; i < 3 && gradients; ++i) out.gradients[3 * place + i] = slope[i];
        }
    }

    Interpolated& out;
    std::vector<std::uint8_t>& known;  // by query
    std::span<const double> values;
    std::size_t components;
    bool gradients;
    std::span<const std::int32_t> numbers;
};

// In a domain without end, the queries that have no coordinates between the near ends, and may have some beyond them.
class FarQueries {
public:
    // numbers: of those without coordinates.
    FarQueries(DiagramState& near, std::span<const double> x, const NaturalOptions& options,
               std::vector<std::int32_t> numbers)
        : options_(options), numbers_(std::move(numbers)) {
        // Along the normal of flat seeds all cells reach infinity.
        if (!near.endless || numbers_.empty() || near.flat_ends) return;
        take(x, options.weights);
        const Box ends = ends_beyond(near, places_, {weights_});
        remove_open(*hull_state(near, ends));
        if (numbers_.empty()) return;
        take(x, options.weights);
        state_ = far_state(near, ends);
    }
    [[nodiscard]] bool any() const { return state_ != nullptr; }
    [[nodiscard]] DiagramState& state() const { return *state_; }
    [[nodiscard]] std::span<const std::int32_t> numbers() const { return numbers_; }
    [[nodiscard]] NaturalOptions options() const {
        NaturalOptions options = options_;
        options.weights = weights_;
        return options;
    }
    [[nodiscard]] const std::vector<double>& places() const { return places_; }

private:
    void take(std::span<const double> x, std::span<const double> weights) {
        places_ = some_of(x, numbers_, 3);
        weights_ = some_of(weights, numbers_, 1);
    }
    // Leaves those whose cells do not reach infinity. The seeds around infinity decide that.
    void remove_open(DiagramState& hull) {
        if (hull.points.empty()) return numbers_.clear();
        ProbeOptions asked;
        asked.want = {.neighbors = true, .volumes = false};
        asked.list_walls = true;
        asked.weights = weights_;
        const Result cells = probe(hull, places_, asked);
        const auto is_end = [&](std::int32_t id) { return hull.endless_sides.has(id); };
        std::size_t kept = 0;
        for (std::size_t k = 0; k < numbers_.size(); ++k)
            if (cells.indptr[k] < cells.indptr[k + 1] && !lists_end(cells, k, is_end)) numbers_[kept++] = numbers_[k];
        numbers_.resize(kept);
    }

    const NaturalOptions& options_;
    std::vector<std::int32_t> numbers_;
    std::vector<double> places_, weights_;
    std::shared_ptr<DiagramState> state_;
};

// Returns rows of NaN. Throws for values of another shape.
Interpolated unknown_rows(const DiagramState& state, std::span<const double> values, std::size_t components,
                          std::size_t queries, bool gradients) {
    const std::size_t seeds = state.points.size() / 3;
    if (components == 0 || values.size() != seeds * components)
        refuse("values hold " + std::to_string(values.size()) + " numbers for " + std::to_string(seeds) +
               " seeds with " + std::to_string(components) + " components: the shape must be (N,m)");
    if (components > std::numeric_limits<std::size_t>::max() / sizeof(double) / 3 / std::max<std::size_t>(queries, 1))
        throw Error(ErrorCode::out_of_memory, std::to_string(components) + " components of " + std::to_string(queries) +
                                                  " queries do not fit into memory");
    Interpolated rows;
    lengthen(rows.values, queries * components, unknown);
    lengthen(rows.gradients, gradients ? 3 * rows.values.size() : 0, unknown);
    return rows;
}

// Puts the rows of `some` in place of those with these numbers.
void put_rows(const Interpolated& some, std::span<const std::int32_t> numbers, std::size_t components,
              Interpolated& all) {
    const auto put = [&](const std::vector<double>& from, std::size_t width, std::vector<double>& to) {
        for (std::size_t k = 0; k < numbers.size() && !from.empty(); ++k)
            std::copy_n(&from[k * width], width, &to[static_cast<std::size_t>(numbers[k]) * width]);
    };
    put(some.values, components, all.values);
    put(some.gradients, 3 * components, all.gradients);
}

// Replaces empty rows, which have these numbers, by those of `some`.
NaturalCoordinates joined(const NaturalCoordinates& all, std::span<const std::int32_t> numbers,
                          const NaturalCoordinates& some) {
    NaturalCoordinates out;
    out.indptr.reserve(all.indptr.size());
    out.indptr.push_back(0);
    std::size_t k = 0;
    for (std::size_t q = 0; q + 1 < all.indptr.size(); ++q) {
        const bool replaced = k < numbers.size() && static_cast<std::size_t>(numbers[k]) == q;
        const NaturalCoordinates& from = replaced ? some : all;
        const std::size_t row = replaced ? k++ : q;
        const std::ptrdiff_t begin = from.indptr[row], end = from.indptr[row + 1];
        out.indices.insert(out.indices.end(), from.indices.begin() + begin, from.indices.begin() + end);
        out.weights.insert(out.weights.end(), from.weights.begin() + begin, from.weights.begin() + end);
        if (!from.gradients.empty())
            out.gradients.insert(out.gradients.end(), from.gradients.begin() + 3 * begin,
                                 from.gradients.begin() + 3 * end);
        out.indptr.push_back(std::ssize(out.indices));
    }
    return out;
}

}  // namespace

namespace {

NaturalCoordinates natural_in_domain(DiagramState& state, std::vector<double> x, const NaturalOptions& options) {
    const Queries queries = check_queries(state, std::move(x), options.weights);
    NaturalCoordinates out;
    lengthen(out.indptr, queries.count() + 1);
    std::mutex mutex;
    std::deque<RowSink::Rows> all;
    run(state, queries, options, [&] {
        const std::scoped_lock lock(mutex);
        return RowSink(out, all.emplace_back(), options.gradients);
    });
    std::partial_sum(out.indptr.begin(), out.indptr.end(), out.indptr.begin());
    const auto size = static_cast<std::size_t>(out.indptr.back());
    lengthen(out.indices, size);
    lengthen(out.weights, size);
    lengthen(out.gradients, options.gradients ? 3 * size : 0);
    for (const RowSink::Rows& rows : all) {
        std::ptrdiff_t from = 0;
        in_pieces(rows.queries.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) {
                const auto q = static_cast<std::size_t>(rows.queries[row]);
                const std::ptrdiff_t to = out.indptr[q], count = out.indptr[q + 1] - to;
                std::copy_n(rows.seeds.begin() + from, count, out.indices.begin() + to);
                std::copy_n(rows.weights.begin() + from, count, out.weights.begin() + to);
                if (options.gradients)
                    std::copy_n(rows.gradients.begin() + 3 * from, 3 * count, out.gradients.begin() + 3 * to);
                from += count;
            }
        });
    }
    std::vector<std::int32_t> missing;
    for (std::size_t q = 0; q < queries.count() && state.endless; ++q)
        if (out.indptr[q] == out.indptr[q + 1]) missing.push_back(static_cast<std::int32_t>(q));
    const FarQueries far(state, queries.x, options, std::move(missing));
    return far.any() ? joined(out, far.numbers(), natural_in_domain(far.state(), far.places(), far.options())) : out;
}

// The queries in the mesh; others have no answer.
struct QueriesInMesh {
    QueriesInMesh(DiagramState& state, std::vector<double> given, const NaturalOptions& options)
        : all(check_queries(state, std::move(given), options.weights)),
          numbers(in_mesh(state, all)),
          places(some_of(all.x, numbers, 3)),
          weights(some_of(options.weights, numbers, 1)),
          asked(options) {
        asked.weights = weights;
    }
    Queries all;
    std::vector<std::int32_t> numbers;
    std::vector<double> places, weights;
    NaturalOptions asked;
};

}  // namespace

NaturalCoordinates natural_neighbors(DiagramState& state, std::vector<double> x, const NaturalOptions& options) {
    if (!state.inside) return natural_in_domain(state, std::move(x), options);
    const QueriesInMesh some(state, std::move(x), options);
    NaturalCoordinates none;
    lengthen(none.indptr, some.all.count() + 1);
    return joined(none, some.numbers, natural_in_domain(state, some.places, some.asked));
}

Interpolated interpolate(DiagramState& state, std::span<const double> values, std::size_t components,
                         std::vector<double> x, const NaturalOptions& options) {
    if (!state.inside) return interpolate_in_domain(state, values, components, std::move(x), options);
    const QueriesInMesh some(state, std::move(x), options);
    Interpolated out = unknown_rows(state, values, components, some.all.count(), options.gradients);
    put_rows(interpolate_in_domain(state, values, components, some.places, some.asked), some.numbers, components, out);
    return out;
}

Interpolated interpolate_in_domain(DiagramState& state, std::span<const double> values, std::size_t components,
                                   std::vector<double> x, const NaturalOptions& options) {
    const Queries queries = check_queries(state, std::move(x), options.weights);
    Interpolated out = unknown_rows(state, values, components, queries.count(), options.gradients);
    std::vector<std::uint8_t> known;
    lengthen(known, queries.count());
    run(state, queries, options, [&] { return SumSink(out, known, values, components, options.gradients); });
    std::vector<std::int32_t> missing;
    for (std::size_t q = 0; q < queries.count() && state.endless; ++q)
        if (known[q] == 0) missing.push_back(static_cast<std::int32_t>(q));
    const FarQueries far(state, queries.x, options, std::move(missing));
    if (far.any())
        put_rows(interpolate_in_domain(far.state(), values, components, far.places(), far.options()), far.numbers(),
                 components, out);
    return out;
}

}  // namespace votess::detail

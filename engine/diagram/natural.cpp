// Natural-neighbor coordinates, as rows or summed with values.
#include <algorithm>
#include <limits>
#include <numeric>

#include "core/progress.hpp"
#include "diagram/diagram_state.hpp"

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
    Options wanted = options_in(state, job.box, weights);
    wanted.want = {};
    wanted.want.volumes = false;
    wanted.want.faces = true;
    wanted.progress = Stoppable::within(stage.part(0, share_of_cells));
    state.graph.emplace(seeds, tessellate(points, wanted), job.scale);
    Stoppable::enter_stage(stage.part(share_of_graph, 1));
    return true;
}

// make_sink: makes the receiver of the rows of a share of the queries. Its `numbers` are those of a run.
template <class MakeSink>
void run(DiagramState& state, const Queries& queries, const NaturalOptions& options, MakeSink make_sink) {
    if (options.gradients && options.method == NaturalMethod::laplace)
        throw Error(ErrorCode::invalid_argument,
                    "gradients are known with Sibson's coordinates: Laplace's have none across some spheres");
    NaturalOptions without_progress = options;
    without_progress.progress = nullptr;
    const CallGuard turn(state);
    const bool with_graph = need_graph(state, queries, options);
    make_searchers(state);
    for (DiagramState::Searcher& searcher : state.searchers) {
        searcher.prober.begin_job(*state.job.domain, cpu::Star::Keep::places);
        searcher.natural.begin_job(state.job, without_progress);
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

}  // namespace

namespace {

// Without walls, rows do not end at any. Queries with these numbers have none in the near box.
struct FarQueries {
    FarQueries(DiagramState& near, std::span<const double> x, const NaturalOptions& options,
               std::span<const std::int32_t> numbers)
        : state(far_state(near)),
          places(some_of(x, numbers, 3)),
          weights(some_of(options.weights, numbers, 1)),
          asked(options) {
        asked.weights = weights;
    }
    DiagramState& state;
    std::vector<double> places, weights;
    NaturalOptions asked;
};

// Leaves those of the queries whose cells do not reach infinity. The seeds around infinity decide that.
void remove_open(DiagramState& state, std::span<const double> x, const NaturalOptions& options,
                 std::vector<std::int32_t>& numbers) {
    const std::vector<double> places = some_of(x, numbers, 3), weights = some_of(options.weights, numbers, 1);
    ProbeOptions asked;
    asked.want = {.neighbors = true, .volumes = false};
    asked.list_walls = true;
    asked.weights = weights;
    const Tessellation cells = probe(hull_state(state), places, asked);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < numbers.size(); ++k)
        if (const auto row = cells.neighbors(k); !row.empty() && row[0] >= 0) numbers[kept++] = numbers[k];
    numbers.resize(kept);
}

NaturalOptions without_walls(const DiagramState& state, const NaturalOptions& options) {
    NaturalOptions asked = options;
    if (state.endless) asked.at_walls = false;
    return asked;
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

NaturalCoordinates natural_neighbors(DiagramState& state, std::span<const double> x, const NaturalOptions& given) {
    const NaturalOptions options = without_walls(state, given);
    const Queries queries = check_queries(state, x, options.weights);
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
    if (!state.endless) return out;
    std::vector<std::int32_t> missing;
    for (std::size_t q = 0; q < queries.count(); ++q)
        if (out.indptr[q] == out.indptr[q + 1]) missing.push_back(static_cast<std::int32_t>(q));
    if (!missing.empty()) remove_open(state, queries.x, options, missing);
    if (missing.empty()) return out;
    const FarQueries far(state, queries.x, options, missing);
    return joined(out, missing, natural_neighbors(far.state, far.places, far.asked));
}

Interpolated interpolate(DiagramState& state, std::span<const double> values, std::size_t components,
                         std::span<const double> x, const NaturalOptions& given) {
    const NaturalOptions options = without_walls(state, given);
    const Queries queries = check_queries(state, x, options.weights);
    const std::size_t seeds = state.points.size() / 3;
    if (components == 0 || values.size() != seeds * components)
        throw Error(ErrorCode::invalid_argument,
                    "values hold " + std::to_string(values.size()) + " numbers for " + std::to_string(seeds) +
                        " seeds with " + std::to_string(components) + " components: the shape must be (N,m)");
    if (components >
        std::numeric_limits<std::size_t>::max() / sizeof(double) / 3 / std::max<std::size_t>(queries.count(), 1))
        throw Error(ErrorCode::out_of_memory, std::to_string(components) + " components of " +
                                                  std::to_string(queries.count()) + " queries do not fit into memory");
    Interpolated out;
    lengthen(out.values, queries.count() * components, unknown);
    lengthen(out.gradients, options.gradients ? 3 * out.values.size() : 0, unknown);
    std::vector<std::uint8_t> known;
    lengthen(known, queries.count());
    run(state, queries, options, [&] { return SumSink(out, known, values, components, options.gradients); });
    if (!state.endless) return out;
    std::vector<std::int32_t> missing;
    for (std::size_t q = 0; q < queries.count(); ++q)
        if (known[q] == 0) missing.push_back(static_cast<std::int32_t>(q));
    if (!missing.empty()) remove_open(state, queries.x, options, missing);
    if (missing.empty()) return out;
    const FarQueries far(state, queries.x, options, missing);
    const Interpolated found = interpolate(far.state, values, components, far.places, far.asked);
    for (std::size_t k = 0; k < missing.size(); ++k) {
        const auto q = static_cast<std::size_t>(missing[k]);
        std::copy_n(&found.values[k * components], components, &out.values[q * components]);
        if (options.gradients)
            std::copy_n(&found.gradients[3 * k * components], 3 * components, &out.gradients[3 * q * components]);
    }
    return out;
}

}  // namespace votess::detail

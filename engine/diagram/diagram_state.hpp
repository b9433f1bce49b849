// What a Diagram holds, and how a call takes its queries: in shares, each sorted along a curve and asked on one thread.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "cpu/cpu_clipper.hpp"
#include "input/job.hpp"
#include "output/result_builder.hpp"
#include "query/locator.hpp"
#include "query/natural_rows.hpp"
#include "query/probe_rows.hpp"
#include "query/prober.hpp"
#include "votess/diagram.hpp"

namespace votess::detail {

// What never changes, and the threads and searches of one call after the other.
struct DiagramState {
    std::vector<double> points;
    Job job;
    cpu::CpuClipper clipper;

    // What a thread needs.
    struct Searcher {
        Searcher(const Job& job, const cpu::SortedSeeds& seeds, const cpu::Hierarchy& hierarchy,
                 const cpu::Kernels& kernels)
            : locator(job, seeds, hierarchy),
              prober(seeds, hierarchy, kernels),
              rows(seeds),
              natural(seeds, hierarchy, kernels) {}

        cpu::Locator locator;
        cpu::Prober prober;
        cpu::ProbeRows rows;
        cpu::NaturalRows natural;
        // The queries taken at once: by number from the first, and sorted along a curve.
        std::vector<cpu::Place> places;
        std::vector<std::uint64_t> order;
        std::vector<cpu::Probe> probes, rest;
    };
    // One call at a time uses what follows, see Turn.
    std::mutex mutex;
    std::condition_variable ended;
    std::thread::id caller;  // no thread's when none is at work
    std::deque<Searcher> searchers;
    ResultBuilder result;
    std::optional<cpu::VertexGraph> graph;  // made when it is worth it
};

// A call's turn with the state. Waits for the call at work, and meanwhile lets the user stop.
class Turn {
public:
    explicit Turn(DiagramState& state);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

private:
    DiagramState& state_;
};

// The queries of a call; weights: times scale squared, or none.
struct Queries {
    std::vector<double> x;  // copied, see input/snapshot.hpp
    std::vector<double> weights;
    [[nodiscard]] std::size_t count() const { return x.size() / 3; }
};
// Throws invalid_argument for what is no (Q, 3), and for weights, or radii, that do not fit.
Queries check_queries(const DiagramState& state, std::span<const double> x, std::span<const double> weights = {},
                      std::span<const double> radii = {});

// The query times the scale of the job.
exact::Point scaled(const Job& job, const Queries& queries, std::size_t number);

// One for each thread. Needs a Turn, as all that follows.
void make_searchers(DiagramState& state);
// task(searcher, begin, end) for all queries, on all threads.
void for_queries(DiagramState& state, const Queries& queries,
                 const std::function<void(DiagramState::Searcher&, std::size_t begin, std::size_t end)>& task);
// Places the queries from `begin` to `end` and sorts those inside the domain; calls leave_out for the others.
void sort_queries(const Job& job, DiagramState::Searcher& searcher, const Queries& queries, std::size_t begin,
                  std::size_t end, const std::function<void(std::size_t)>& leave_out);
// After it: their cells. run(queries, near) for each run of probes, which stand in searcher.probes.
void for_runs(const Job& job, DiagramState::Searcher& searcher, const Queries& queries, std::size_t begin,
              std::span<std::int32_t> numbers,
              const std::function<void(std::span<const std::int32_t> numbers, std::size_t near)>& run);

std::vector<std::int32_t> locate(DiagramState& state, const Queries& queries);
Tessellation probe(DiagramState& state, std::span<const double> x, const ProbeOptions& options);
NaturalCoordinates natural_neighbors(DiagramState& state, std::span<const double> x, const NaturalOptions& options);
Interpolated interpolate(DiagramState& state, std::span<const double> values, std::size_t components,
                         std::span<const double> x, const NaturalOptions& options);
std::size_t to_grid(DiagramState& state, std::span<const double> values, const GridOptions& options,
                    std::span<double> grid);

}  // namespace votess::detail

// The state of a Diagram. A call splits its queries into shares; one thread sorts each share along a curve and answers
// it.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
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
#include "query/ray_tracer.hpp"
#include "solid/inside.hpp"
#include "unbounded/endless_box.hpp"
#include "unbounded/flat_ends.hpp"
#include "votess/diagram.hpp"

namespace votess::detail {

// The constant seeds, and the threads and searches, which one call at a time uses.
struct DiagramState {
    std::vector<double> points;
    Job job;
    cpu::CpuClipper clipper;

    // The state of a thread.
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
    // One call at a time uses the members below, see CallGuard.
    std::mutex mutex;
    std::condition_variable ended;
    std::thread::id caller;  // no thread's when none is at work
    std::deque<Searcher> searchers;
    ResultBuilder result;
    std::optional<cpu::VertexGraph> graph;  // made when it is worth it
    std::optional<cpu::CellGraph> cells;    // made for rays

    [[nodiscard]] bool planar() const { return job.region.thickness > 0; }  // then it is that of a sheet
    // The sides at infinity. The walls of the state's own box on them are not those of the domain.
    EndlessSides endless_sides;

    // In a domain without end this state has near ends, and others are made when needed. `far` has ends beyond what
    // the queries reach. `flat` has too, cut by the ends of flat seeds. `hull` has those ends too, but only the seeds
    // whose cells reach infinity. `around` has sides around the seeds, for grids. Each has its own call at work.
    std::optional<Edges> endless;
    Box ends;  // along these edges
    std::mutex making;
    std::shared_ptr<DiagramState> far, flat, hull, around;
    std::optional<FlatEnds> flat_ends;              // if there are any
    std::optional<std::vector<std::int32_t>> open;  // the seeds of `hull`

    // A mesh, which cuts the domain. The others have none.
    std::optional<solid::Inside> inside;
};

// Make the state of a Diagram, with its points in space: those of a plane lie in a sheet. The second one is a call that
// the user may stop.
std::shared_ptr<DiagramState> make_state(Settled run);
std::shared_ptr<DiagramState> make_state(const ProgressCallback& progress, const std::function<Settled()>& settle);
// Returns the weights as given; none without a power diagram.
Weights weights_of(const DiagramState& state);
// Returns a run of all seeds in that region, on the CPU.
Settled run_in(const DiagramState& state, Region region);

// Return ends for the seeds of a state without end: some that hold these places too, and some that hold all vertices of
// the diagram of the seeds and any one query. weights: of the queries, as given; empty: 0.
Box ends_with(const DiagramState& state, std::span<const double> places);
Box ends_beyond(const DiagramState& state, std::span<const double> places, const Weights& weights);
// Return those of a state without end. ends: what theirs have to hold.
std::shared_ptr<DiagramState> far_state(DiagramState& state, const Box& ends);
std::shared_ptr<DiagramState> flat_state(DiagramState& state, const Box& ends);
std::shared_ptr<DiagramState> hull_state(DiagramState& state, const Box& ends);
std::shared_ptr<DiagramState> state_around(DiagramState& state);

// Gives one call the state. Waits for the call at work, and meanwhile checks whether the user stops.
class CallGuard {
public:
    explicit CallGuard(DiagramState& state);
    ~CallGuard();
    CallGuard(const CallGuard&) = delete;
    CallGuard& operator=(const CallGuard&) = delete;

private:
    DiagramState& state_;
};

// Returns vectors as given, (N, 3), or those of a plane in its sheet. Throws invalid_argument for another number of
// components. name: for messages.
std::vector<double> in_space(const DiagramState& state, std::span<const double> vectors, const char* name);

// The queries of a call; weights: times scale squared, or none.
struct Queries {
    std::vector<double> x;
    std::vector<double> weights;
    [[nodiscard]] std::size_t count() const { return x.size() / 3; }
};
// x: (Q, 3). Throws invalid_argument for weights or radii of another length.
Queries check_queries(const DiagramState& state, std::vector<double> x, std::span<const double> weights = {},
                      std::span<const double> radii = {});

// Returns the rows of `each` coordinates or weights that have these numbers; none of none.
std::vector<double> some_of(std::span<const double> all, std::span<const std::int32_t> numbers, std::size_t each);

// The query times the scale of the job.
exact::Point scaled(const Job& job, const Queries& queries, std::size_t number);

// Makes a searcher for each thread. Needs a CallGuard, like the functions below.
void make_searchers(DiagramState& state);
// task(searcher, begin, end) for all queries, on all threads.
void for_queries(DiagramState& state, const Queries& queries,
                 const std::function<void(DiagramState::Searcher&, std::size_t begin, std::size_t end)>& task);
// Places the queries from `begin` to `end` and sorts those inside the domain. Calls skip for the others.
void sort_queries(const Job& job, DiagramState::Searcher& searcher, const Queries& queries, std::size_t begin,
                  std::size_t end, const std::function<void(std::size_t)>& skip);
// After sort_queries(): calls run(numbers, near) for each run of probes in searcher.probes.
void for_runs(const Job& job, DiagramState::Searcher& searcher, const Queries& queries, std::size_t begin,
              std::span<std::int32_t> numbers,
              const std::function<void(std::span<const std::int32_t> numbers, std::size_t near)>& run);

// Returns the numbers of the queries that lie in the mesh, ascending.
std::vector<std::int32_t> in_mesh(DiagramState& state, const Queries& queries);

// Those that end with _in_domain leave the mesh out.
std::vector<std::int32_t> locate(DiagramState& state, const Queries& queries);
std::vector<std::int32_t> locate_in_domain(DiagramState& state, const Queries& queries);
// All vectors of these are in space.
RayCells trace(DiagramState& state, std::vector<double> origins, std::vector<double> directions,
               std::span<const double> lengths, bool middles);
Result probe(DiagramState& state, std::vector<double> x, const ProbeOptions& options);
NaturalCoordinates natural_neighbors(DiagramState& state, std::vector<double> x, const NaturalOptions& options);
Interpolated interpolate(DiagramState& state, std::span<const double> values, std::size_t components,
                         std::vector<double> x, const NaturalOptions& options);
Interpolated interpolate_in_domain(DiagramState& state, std::span<const double> values, std::size_t components,
                                   std::vector<double> x, const NaturalOptions& options);
std::size_t to_grid(DiagramState& state, std::span<const double> values, const GridOptions& options,
                    std::span<double> grid);

}  // namespace votess::detail

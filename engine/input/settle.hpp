// Settles a run: checks points and options, and derives the domain. Throws Error(invalid_argument), which names the
// first offender.
#pragma once

#include "input/job.hpp"
#include "votess/export.hpp"

namespace votess {

class ThreadPool;

// Checks the options and settles them, without seeds. Copies weights and subset. The choice of an engine checks whether
// the device is there.
[[nodiscard]] VOTESS_API Settled settle(const Options& options);
// Checks the number of points too.
[[nodiscard]] Settled settle(const Points& points, const Options& options);
// Returns the options of a run, without weights and subset.
[[nodiscard]] VOTESS_API Options options_of(const Settled& run);

// Returns the domain that options give, unchecked.
[[nodiscard]] VOTESS_API Region region_of(const Options& options);

// Checks a number of a call that has an option's meaning and limits. name: as PieceOptions::threads.
void check_member(const char* name, unsigned value);
// Returns weights or radii. Throws invalid_argument if both are given.
[[nodiscard]] Weights weights_of(std::span<const double> weights, std::span<const double> radii);
// Returns the weights of `count` points, times scale squared. of: the points' name in messages; first: the number of
// the first one.
std::vector<double> scaled_weights(Weights weights, std::size_t count, const char* of, double scale,
                                   std::uint64_t first = 0);
// Checks the number of points.
void check_shape(const Points& points, bool planar = false);
// Checks the points, against a box if there is one, and returns their bounds. outside: as in the job. pool: null for
// the calling thread alone.
Box check_points(const Points& points, const Region& region, std::vector<CellStatus>& outside,
                 ThreadPool* pool = nullptr);
// Returns the box of a run without a cell. bounds: of all `count` seeds.
Box box_of(const Region& region, const Box& bounds, std::uint64_t count);
// Checks the seeds in a region of space that has ends, and derives its domain. pool: as for check_points().
[[nodiscard]] Job make_job(Settled run, ThreadPool* pool = nullptr);

// Runs settled runs, as a Tessellator does. In run/.
class Runner {
public:
    Runner();
    [[nodiscard]] Tessellation operator()(Settled run);

private:
    std::shared_ptr<detail::TessellatorState> state_;
};
[[nodiscard]] inline Tessellation tessellate(Settled run) {
    return Runner()(std::move(run));
}
// Returns the arrays alone.
[[nodiscard]] detail::Result arrays_of(Settled run);

}  // namespace votess

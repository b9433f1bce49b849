// Checks the user's input and derives the domain. Throws Error(invalid_argument), which names the first offender.
#pragma once

#include "input/job.hpp"

namespace votess {

class ThreadPool;

// Checks the options alone. The choice of an engine checks whether the device is there.
void check_options(const Options& options);
void check_box(const Box& box);
// Returns the weights, or squares of radii, of `count` points, times scale squared; none if the options have none.
// of: the points' name in messages; first: the number of the first one.
std::vector<double> scaled_weights(const Options& options, std::size_t count, const char* of, double scale,
                                   std::uint64_t first = 0);
// Checks the number of points.
void check_shape(const Points& points);
// Checks the points, against a box if there is one, and returns their bounds. outside: as in the job. pool: null for
// the calling thread alone.
Box check_points(const Points& points, const Options& options, std::vector<CellStatus>& outside,
                 ThreadPool* pool = nullptr);
// Returns the box of a run without a cell. bounds: of all `count` seeds.
Box box_of(const Options& options, const Box& bounds, std::uint64_t count);
// Checks options and points. pool: as for check_points().
Job validate(const Points& points, const Options& options, ThreadPool* pool = nullptr);

}  // namespace votess

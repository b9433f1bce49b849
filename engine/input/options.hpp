// Checks what the user gave and derives the domain. Throws Error(invalid_argument) naming the first offender.
#pragma once

#include "input/job.hpp"

namespace votess {

// The options alone. Whether the device is there is the concern of whoever selects the engine.
void check_options(const Options& options);
void check_box(const Box& box);
void check_k_init(std::uint32_t k_init);
// The weights, or squares of radii, that `count` points have by the options, times scale squared; none if these name
// none. of: what the points are called; first: the number of the first one.
std::vector<double> scaled_weights(const Options& options, std::size_t count, const char* of, double scale,
                                   std::uint64_t first = 0);
// How many points there are, without a look at them.
void check_shape(const Points& points);
// The points alone, against a box if there is one: their bounds. outside: as in the job.
Box check_points(const Points& points, const Options& options, std::vector<CellStatus>& outside);
// The box of the run, where options name no cell; bounds: of all seeds, of which there are `count`.
Box box_of(const Options& options, const Box& bounds, std::uint64_t count);
// Options and points.
Job validate(const Points& points, const Options& options);

}  // namespace votess

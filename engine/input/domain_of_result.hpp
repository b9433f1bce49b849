// The domain of a result, for functions that take one.
#pragma once

#include <span>
#include <string>

#include "input/job.hpp"
#include "votess/votess.hpp"

namespace votess {

// Returns box or cell, periodic axes and walls, without weights. Seeds outside are kept, unless some were dropped.
Region region_of(const Tessellation& tessellation);
// Returns a run of these points with the region and the weights of a result, on the CPU.
Settled run_of(const Tessellation& tessellation, std::span<const double> points);

// Moves each of the job's points that is not `outside` into a periodic domain, by whole box vectors. Each coordinate is
// rounded once. places: 3N, the points.
void move_into_domain(const Job& job, std::span<double> places);

// Throws invalid_argument unless the points have a row of coordinates for each cell. function: for the message.
void require_points(const Tessellation& tessellation, std::span<const double> points, const std::string& function);
// Refuses also points that are not finite, which no result has.
void require_finite_points(const Tessellation& tessellation, std::span<const double> points,
                           const std::string& function);

}  // namespace votess

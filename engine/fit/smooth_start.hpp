// Weights near those of a fit under a density.
#pragma once

#include <optional>
#include <span>

#include "fit/newton.hpp"
#include "input/job.hpp"

namespace votess::fit {

// Returns weights of the entropic transport from the density to the seeds, of the mean 0. All cells then have about
// their masses if the density is smooth over the distance of seeds. Nothing for a skewed domain. Also nothing where the
// density is 0 at all nodes of the grid that it works on. places: 3N, inside a periodic domain.
[[nodiscard]] std::optional<Vector> smooth_start(const Job& job, const Under& density, std::span<const double> places,
                                                 const Vector& targets, const Edges& edges, int dimensions,
                                                 ThreadPool& pool);

}  // namespace votess::fit

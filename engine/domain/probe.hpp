// A query among the seeds, with the data to build its cell.
#pragma once

#include "exact/predicate.hpp"

namespace votess::cpu {

// A place after a shift into a periodic domain, or into the reduced cell of a skewed one.
struct Place {
    exact::Point at{};            // rounded if it has been moved
    std::array<double, 3> low{};  // rounding error of `at`
    exact::Shift shift{};
    exact::Shift move{};  // the part of `shift` from the domain into its reduced cell
};

struct Probe {
    exact::Point x{};  // as given, times the scale of the job
    Place place;
    double weight = 0;  // 0 if seeds have no weights
};

}  // namespace votess::cpu

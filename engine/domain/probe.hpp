// A query among the seeds: where it lies, and what is needed to build the cell that it would have.
#pragma once

#include "exact/predicate.hpp"

namespace votess::cpu {

// After it has been wrapped into a periodic domain, or into the reduced cell of a skewed one, by a shift.
struct Place {
    exact::Point at{};            // rounded where it has been moved
    std::array<double, 3> low{};  // what rounding took
    exact::Shift shift{};
    exact::Shift move{};  // the part of `shift` from the domain into its reduced cell
};

struct Probe {
    exact::Point x{};  // as given, times the scale of the job
    Place place;
    double weight = 0;  // 0 where seeds have none
};

}  // namespace votess::cpu

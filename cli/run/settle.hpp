// From points that were read to the options of their run: columns, weights, dimensions and the domain.
#pragma once

#include <cstddef>
#include <vector>
#include <votess/votess.hpp>

#include "arguments/arguments.hpp"
#include "domain.hpp"
#include "read/input.hpp"

namespace clvotess {

struct Settled {
    Input input;
    votess::Options options;  // weights and radii are views into the input. With --box hull, set_hull() adds the walls
    DomainFrom domain_from;
    std::vector<InputColumn> carried;  // into the outputs; empty for a query
};

// Throws Failure.
[[nodiscard]] Settled settle(const Arguments& arguments, Input input);

// Completes the domain of the options from what a file states. Throws Failure.
[[nodiscard]] DomainFrom settle_domain(const Arguments& arguments, std::size_t dimensions, const FileDomain& stated,
                                       votess::Options& options);

}  // namespace clvotess

// A run as a part of another.
#pragma once

#include <functional>

#include "input/job.hpp"

namespace votess {

// Runs points in a box with ends; weights or radii are those of the options.
using RunInBox = std::function<detail::Result(const Points&, const Options&)>;

}  // namespace votess

// A run as a part of another.
#pragma once

#include <functional>

#include "input/settled.hpp"

namespace votess {

// Runs in a region with ends.
using RunInBox = std::function<detail::Result(Settled)>;

}  // namespace votess

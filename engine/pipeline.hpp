#pragma once

#include "engine.hpp"

namespace votess {

// Runs the six stages on a validated job and times them.
detail::Result run_pipeline(const Points& points, const Options& options, Engine& engine);

}  // namespace votess

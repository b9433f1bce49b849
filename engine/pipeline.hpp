#pragma once

#include "engine.hpp"

namespace votess {

// Runs the six stages on a validated job and times them. arrays: memory of an earlier result to use again.
detail::Result run_pipeline(const Points& points, const Options& options, Engine& engine, detail::Result arrays = {});

}  // namespace votess

// The fit of weights to volumes.
#pragma once

#include <functional>
#include <span>

#include "input/settled.hpp"
#include "votess/fit.hpp"

namespace votess::fit {

// settle: makes the run of `seeds` points. targets: their volumes.
[[nodiscard]] VolumeFit fit_volumes(const std::function<Settled()>& settle, std::size_t seeds,
                                    std::span<const double> targets, const FitOptions& options);

}  // namespace votess::fit

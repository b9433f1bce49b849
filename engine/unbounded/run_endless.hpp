// A run in a domain without end.
#pragma once

#include "input/run_in_box.hpp"
#include "result/result.hpp"

namespace votess {

// Returns the cells of the points in options.box, some of whose bounds are infinite. Most cells of many points end
// in near_box(), on any device. The CPU makes the others again in far_box(), among themselves and their near neighbors.
// That is enough: a face of such a cell meets the near box, or the neighbor behind it also reaches beyond that box. A
// cell that is empty in the near box may lie beyond it. Then all cells are made in the far box.
[[nodiscard]] detail::Result run_endless(const Points& points, const Options& options, const RunInBox& run);

}  // namespace votess

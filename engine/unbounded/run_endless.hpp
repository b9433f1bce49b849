// A run in a domain without end.
#pragma once

#include "input/run_in_box.hpp"
#include "result/result.hpp"

namespace votess {

// Returns the cells of a run in a domain some of whose sides are at infinity. Most cells of many points end
// between near ends, on any device. The CPU makes the others again between far ones, among themselves and their near
// neighbors. That is enough: a face of such a cell meets the near box, or the neighbor behind it also reaches beyond
// it. A cell that is empty in the near box may lie beyond it. Then all cells are made in the far box.
[[nodiscard]] detail::Result run_endless(const Settled& whole, const RunInBox& run);

}  // namespace votess

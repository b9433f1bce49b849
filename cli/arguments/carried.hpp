// Columns of the input that a run uses: weights or radii, and what goes into the output.
#pragma once

#include <span>
#include <vector>
#include <votess/votess.hpp>

#include "arguments/arguments.hpp"
#include "read/input.hpp"

namespace clvotess {

// The weights or radii of the options become those of the input, which owns them.
void take_weights(const Arguments& arguments, Input& input, votess::Options& options);

// The columns that go into the output, the last one still empty if it is to be the density.
[[nodiscard]] std::vector<InputColumn> take_carried(const Arguments& arguments, Input& input);

// Fills that last one. A cell without a volume has no density.
void fill_density(const Arguments& arguments, const Input& input, std::span<const double> volumes,
                  std::vector<InputColumn>& carried);

}  // namespace clvotess

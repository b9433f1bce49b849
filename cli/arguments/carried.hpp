// Columns of the input that a run uses: weights or radii, and what goes into the output.
#pragma once

#include <span>
#include <vector>
#include <votess/votess.hpp>

#include "arguments/arguments.hpp"
#include "read/input.hpp"

namespace clvotess {

// A file of no points has no columns: adds empty ones for those that the arguments name.
void complete_columns(const Arguments& arguments, Input& input);

// The weights or radii of the options become those of the input, which owns them.
void take_weights(const Arguments& arguments, const Input& input, votess::Options& options);

// The columns that go into the output, taken out of the input, the last one still empty if it is to be the density.
[[nodiscard]] std::vector<InputColumn> take_carried(const Arguments& arguments, Input& input);

// Fills that one, if there is to be one. A cell without a volume has no density.
void fill_density(const Arguments& arguments, const Input& input, std::span<const double> volumes,
                  std::vector<InputColumn>& carried);

}  // namespace clvotess

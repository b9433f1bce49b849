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

// Returns the numbers of --density, which the input keeps; none without that option.
[[nodiscard]] std::vector<double> masses_of(const Arguments& arguments, const Input& input);

// Adds the mass of each duplicate to that of the seed that keeps the cell. duplicate_of: empty, or -1 for other seeds.
template <class Index>
void merge_masses(std::span<const Index> duplicate_of, std::vector<double>& masses) {
    if (masses.empty()) return;
    for (std::size_t i = 0; i < duplicate_of.size(); ++i)
        if (duplicate_of[i] >= 0) masses[static_cast<std::size_t>(duplicate_of[i])] += masses[i];
}

// Returns masses over volumes; NaN for a seed without a cell, also for a duplicate.
[[nodiscard]] std::vector<double> densities(std::span<const double> masses, std::span<const double> volumes);

// Fills the last of the columns, if there is to be a density.
void fill_density(const Arguments& arguments, std::span<const double> masses, std::span<const double> volumes,
                  std::vector<InputColumn>& carried);

}  // namespace clvotess

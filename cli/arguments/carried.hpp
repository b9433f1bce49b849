// Columns of the input that a run uses: weights or radii, volumes, masses, and columns carried into the output.
#pragma once

#include <span>
#include <vector>
#include <votess/votess.hpp>

#include "arguments/arguments.hpp"
#include "read/input.hpp"

namespace clvotess {

// Adds the columns that the arguments name, empty, where a file of no points has none. Puts the radii of --radii
// covalent before them. Throws Failure for a species that is not an element.
void complete_columns(const Arguments& arguments, Input& input);

// Sets the weights or radii of the options to views into the input.
void take_weights(const Arguments& arguments, const Input& input, votess::Options& options);

// Returns the target volumes of --volumes, a view into the input.
[[nodiscard]] std::span<const double> targets_of(const Arguments& arguments, const Input& input);

// Moves the carried columns out of the input. Empty columns follow: `zone` with --watershed, `weights` with --volumes,
// and last `density` with that option.
[[nodiscard]] std::vector<InputColumn> take_carried(const Arguments& arguments, Input& input);

// Returns a copy of the masses of --density; empty without that option.
[[nodiscard]] std::vector<double> masses_of(const Arguments& arguments, const Input& input);

// Adds the mass of each duplicate to the seed that keeps the cell. duplicate_of: empty, or -1 for other seeds.
template <class Index>
void merge_masses(std::span<const Index> duplicate_of, std::vector<double>& masses) {
    if (masses.empty()) return;
    for (std::size_t i = 0; i < duplicate_of.size(); ++i)
        if (duplicate_of[i] >= 0) masses[static_cast<std::size_t>(duplicate_of[i])] += masses[i];
}

// Returns masses over volumes; NaN for a seed without a cell, which includes duplicates.
[[nodiscard]] std::vector<double> densities(std::span<const double> masses, std::span<const double> volumes);

// Fills the column `weights` with --volumes.
void fill_weights(const Arguments& arguments, std::span<const double> weights, std::vector<InputColumn>& carried);

// Fills the last column with --density.
void fill_density(const Arguments& arguments, std::span<const double> masses, std::span<const double> volumes,
                  std::vector<InputColumn>& carried);

// Fills the column `zone` with --watershed, after fill_density().
void fill_zones(const Arguments& arguments, const Input& input, const votess::Tessellation& tessellation,
                std::vector<InputColumn>& carried);

}  // namespace clvotess

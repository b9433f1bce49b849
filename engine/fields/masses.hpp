// The density that is constant in the cells of a grid, integrated over cells and faces.
#pragma once

#include <string>
#include <vector>

#include "core/thread_pool.hpp"
#include "fields/flat_cells.hpp"
#include "fields/frame.hpp"
#include "votess/density.hpp"

namespace votess::fields {

// Returns a copy of the values. function: for messages. may_be_zero: whether all of them may be 0.
[[nodiscard]] std::vector<double> checked_values(const Density& density, bool planar, const std::string& function,
                                                 bool may_be_zero);

// values: of the cells of the frame. t: with faces, or with neighbors and `flat`, the cells of a sheet. walls: whether
// their faces have masses too; else 0.
[[nodiscard]] Masses masses_in(const Tessellation& t, const Frame& frame, std::span<const double> values,
                               ThreadPool& pool, bool walls, const FlatCells* flat = nullptr);

}  // namespace votess::fields

// The methods of to_grid(). Each adds to a grid of zeros.
#pragma once

#include <optional>
#include <span>

#include "core/thread_pool.hpp"
#include "fields/frame.hpp"
#include "result/result.hpp"

namespace votess::fields {

// What all of them are given, checked.
struct Task {
    const Tessellation& tessellation;
    std::span<const double> points, values;
    std::size_t columns;
    ThreadPool& pool;
};

void add_mean(const Task& task, const Frame& frame, std::span<double> grid);
// Returns the number of seeds whose mass has no place. result: of the tessellation.
std::size_t add_dtfe(const Task& task, const detail::Result& result, const Frame& frame, std::span<double> grid);
// Along an axis that is projected the grid has one element, to which all grid cells of the frame add.
void add_nearest(const Task& task, const Frame& frame, std::optional<int> projected, std::span<double> grid);

}  // namespace votess::fields

// The methods of to_grid(). Each adds to a grid of zeros.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "core/thread_pool.hpp"
#include "fields/frame.hpp"
#include "result/result.hpp"
#include "votess/pieces.hpp"

namespace votess::fields {

// The checked input of all methods. Along a projected axis the grid has one element, the sum over all grid cells of the
// frame.
struct Task {
    const Frame& frame;
    std::span<const double> values;  // (N, columns)
    std::size_t columns;
    std::span<double> grid;
    std::optional<int> projected;
};

// The seeds and their cells, with faces.
struct Built {
    const Job& job;  // whose points are in float64
    const detail::Result& result;
    const Tessellation& tessellation;  // of the result
};

void add_mean(const Task& task, const Built& built, ThreadPool& pool);
// pieces: of all seeds, in a mesh.
void add_mean(const Task& task, const Pieces& pieces, ThreadPool& pool);
// Fills the grid with densities, in the plane from a result that is flat; along an axis that is projected, with column
// densities. Returns the number of seeds whose mass has no place. Throws invalid_argument for densities that float64
// cannot hold.
std::size_t add_dtfe(const Task& task, const Built& built, ThreadPool& pool);
// evaluate(centers, field): writes a row of columns for each center of a grid cell.
void add_at_centers(const Task& task,
                    const std::function<void(std::span<const double> centers, std::span<double> field)>& evaluate);

}  // namespace votess::fields

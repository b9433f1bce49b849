// Methods that look at the field in the centers of grid cells.
#include <algorithm>
#include <vector>

#include "fields/methods.hpp"
#include "input/domain_of_result.hpp"
#include "votess/diagram.hpp"

namespace votess::fields {
namespace {

constexpr std::size_t centers_at_once = std::size_t{1} << 20;

// The seeds of the result, to be asked.
Diagram diagram_of(const Task& task) {
    Options options = domain_options(task.tessellation);
    options.weights = task.tessellation.weights();
    options.threads = task.pool.size();
    return Diagram(task.points, options);
}

// evaluate(centers, values): writes a row of columns for each center.
template <class Evaluate>
void add_at_centers(const Task& task, const Frame& frame, std::optional<int> projected, std::span<double> grid,
                    const Evaluate& evaluate) {
    const std::size_t cells = frame.cells(), m = task.columns;
    std::vector<double> centers, values;
    for (std::size_t begin = 0; begin < cells; begin += centers_at_once) {
        const std::size_t count = std::min(centers_at_once, cells - begin);
        centers.clear();
        for (std::size_t cell = begin; cell < begin + count; ++cell) {
            const Vector center = frame.center(frame.cell(cell));
            centers.insert(centers.end(), center.begin(), center.end());
        }
        values.assign(count * m, 0);
        evaluate(centers, values);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t to = frame.index(frame.cell(begin + i), projected);
            for (std::size_t c = 0; c < m; ++c) grid[to * m + c] += values[i * m + c];
        }
    }
}

}  // namespace

void add_nearest(const Task& task, const Frame& frame, std::optional<int> projected, std::span<double> grid) {
    const Diagram diagram = diagram_of(task);
    add_at_centers(task, frame, projected, grid, [&](std::span<const double> centers, std::span<double> values) {
        const std::vector<std::int32_t> seeds = diagram.locate(centers);
        const std::size_t m = task.columns;
        for (std::size_t q = 0; q < seeds.size(); ++q)
            if (seeds[q] >= 0) std::copy_n(&task.values[static_cast<std::size_t>(seeds[q]) * m], m, &values[q * m]);
    });
}

}  // namespace votess::fields

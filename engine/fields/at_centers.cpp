// Methods that look at the field in the centers of grid cells.
#include <algorithm>
#include <vector>

#include "core/progress.hpp"
#include "fields/methods.hpp"

namespace votess::fields {
namespace {

constexpr std::size_t centers_at_once = std::size_t{1} << 20;

}  // namespace

void add_at_centers(const Task& task, const std::function<void(std::span<const double>, std::span<double>)>& evaluate) {
    const std::size_t cells = task.frame.cells(), m = task.columns;
    const Share stage = Stoppable::stage();
    std::vector<double> centers, field;
    for (std::size_t begin = 0; begin < cells; begin += centers_at_once) {
        const std::size_t count = std::min(centers_at_once, cells - begin);
        Stoppable::enter_stage({stage.at(begin, cells), stage.at(begin + count, cells)});
        centers.clear();
        in_pieces(count, [&](std::size_t from, std::size_t to) {
            for (std::size_t cell = begin + from; cell < begin + to; ++cell) {
                const Vector center = task.frame.center(task.frame.cell(cell));
                centers.insert(centers.end(), center.begin(), center.end());
            }
        });
        field.assign(count * m, 0);
        evaluate(centers, field);
        in_pieces(count, [&](std::size_t from, std::size_t end) {
            for (std::size_t i = from; i < end; ++i) {
                const std::size_t to = task.frame.index(task.frame.cell(begin + i), task.projected);
                for (std::size_t c = 0; c < m; ++c) task.grid[to * m + c] += field[i * m + c];
            }
        });
    }
}

}  // namespace votess::fields

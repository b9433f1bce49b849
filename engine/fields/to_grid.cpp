// to_grid(): what is asked is checked, and handed to a method.
#include <algorithm>
#include <new>
#include <string>
#include <thread>

#include "fields/methods.hpp"
#include "input/domain_of_result.hpp"
#include "votess/fields.hpp"

namespace votess {
namespace {

constexpr std::size_t most_along_axis = std::size_t{1} << 20, most_columns = std::size_t{1} << 20;
constexpr unsigned most_threads = 1024;

[[noreturn]] void refuse(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, "to_grid: " + message);
}

// How many grid cells there are, along an axis that is projected one.
std::size_t count_grid_cells(const GridOptions& options) {
    std::size_t cells = 1;
    for (int k = 0; k < 3; ++k) {
        const std::size_t along = options.shape[static_cast<std::size_t>(k)];
        if (along == 0 || along > most_along_axis)
            refuse("shape[" + std::to_string(k) + "] = " + std::to_string(along) + " is not from 1 to " +
                   std::to_string(most_along_axis));
        if (k != options.project) cells *= along;
    }
    return cells;
}

void check(const detail::Result& result, std::span<const double> points, std::span<const double> values,
           const GridOptions& options, std::span<const double> grid) {
    const std::size_t n = result.status.size();
    if (options.method != GridMethod::mean && options.method != GridMethod::dtfe &&
        options.method != GridMethod::nearest)
        refuse("method = " + std::to_string(static_cast<int>(options.method)) +
               " is none: it is 0 mean, 1 dtfe or 2 nearest");
    if (options.project && (*options.project < 0 || *options.project > 2))
        refuse("project = " + std::to_string(*options.project) + " is no axis: give 0, 1 or 2");
    if (options.columns == 0 || options.columns > most_columns)
        refuse("columns = " + std::to_string(options.columns) + " is not from 1 to " + std::to_string(most_columns));
    if (options.threads > most_threads)
        refuse("threads = " + std::to_string(options.threads) + " is too many: give at most " +
               std::to_string(most_threads) + ", or 0 for all");
    if (grid.size() != count_grid_cells(options) * options.columns)
        refuse("the grid holds " + std::to_string(grid.size()) + " numbers, its shape needs " +
               std::to_string(count_grid_cells(options) * options.columns));
    if (points.size() != 3 * n)
        refuse("points hold " + std::to_string(points.size()) + " coordinates, the result has " + std::to_string(n) +
               " cells");
    if (values.size() != n * options.columns)
        refuse("there are " + std::to_string(values.size()) + " values, " + std::to_string(n) + " cells need " +
               std::to_string(options.columns) + " each");
    if (options.method == GridMethod::nearest) return;
    if (result.face_offsets.empty() && n > 0) refuse("the tessellation has no polygons, set want.faces");
    if (result.least_face > 0) refuse("the tessellation has lost faces, set min_face and min_area to 0");
}

// Returns how many seeds have mass that has no place.
std::size_t fill(const Tessellation& t, const detail::Result& result, std::span<const double> points,
                 std::span<const double> values, const GridOptions& options, std::span<double> grid) {
    ThreadPool pool(options.threads != 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency()));
    const fields::Task task{t, points, values, options.columns, pool};
    std::array<std::size_t, 3> shape = options.shape;
    // What is integrated needs no steps.
    if (options.project && options.method != GridMethod::nearest) shape[static_cast<std::size_t>(*options.project)] = 1;
    const fields::Frame frame(t, shape);
    std::size_t without_place = 0;
    if (options.method == GridMethod::mean) fields::add_mean(task, frame, grid);
    if (options.method == GridMethod::dtfe) without_place = fields::add_dtfe(task, result, frame, grid);
    if (options.method == GridMethod::nearest) fields::add_nearest(task, frame, options.project, grid);
    if (options.project) {
        const fields::Axis& axis = frame.axis(static_cast<std::size_t>(*options.project));
        for (double& x : grid) x *= axis.length / static_cast<double>(axis.count);
    }
    return without_place;
}

}  // namespace

std::size_t to_grid(const Tessellation& tessellation, std::span<const double> points, std::span<const double> values,
                    const GridOptions& options, std::span<double> grid) {
    require_whole_diagram(tessellation, "to_grid");
    const detail::Result& result = *tessellation.result_;
    check(result, points, values, options, grid);
    std::ranges::fill(grid, 0);
    if (tessellation.size() == 0) return 0;
    try {
        return fill(tessellation, result, points, values, options, grid);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, "to_grid: out of memory");
    }
}

}  // namespace votess

// Diagram::to_grid(): checks the request and calls its method.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/progress.hpp"
#include "diagram/diagram_state.hpp"
#include "fields/methods.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "plane/sheet.hpp"
#include "votess/pieces.hpp"

namespace votess::detail {
namespace {

constexpr double share_of_building = 0.5;  // of a call that builds them
constexpr std::size_t max_along_axis = std::size_t{1} << 20, max_columns = std::size_t{1} << 20;
constexpr std::size_t max_numbers = std::size_t{1} << 44;  // of a grid: as many doubles as addresses reach

[[noreturn]] void refuse_grid(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, "to_grid(): " + message);
}

// How many grid cells there are, along an axis that is projected one.
std::size_t count_grid_cells(const GridOptions& options) {
    std::size_t cells = 1;
    for (int k = 0; k < 3; ++k) {
        const std::size_t along = options.shape[static_cast<std::size_t>(k)];
        if (along == 0 || along > max_along_axis)
            refuse_grid("shape[" + std::to_string(k) + "] = " + std::to_string(along) + " is not from 1 to " +
                        std::to_string(max_along_axis));
        if (k != options.project) cells *= along;
    }
    return cells;
}

void check(const DiagramState& state, std::span<const double> values, const GridOptions& options,
           std::span<const double> grid) {
    const std::size_t seeds = state.points.size() / 3;
    const bool planar = state.planar();
    if (options.method < GridMethod::mean || options.method > GridMethod::sibson)
        refuse_grid("method = " + std::to_string(static_cast<int>(options.method)) +
                    " is none: it is 0 mean, 1 dtfe, 2 nearest or 3 sibson");
    if (options.project && (*options.project < 0 || *options.project > (planar ? 1 : 2)))
        refuse_grid("project = " + std::to_string(*options.project) + " is not an axis: give " +
                    (planar ? "0 or 1" : "0, 1 or 2"));
    if (planar && options.shape[2] != 1)
        refuse_grid("shape[2] = " + std::to_string(options.shape[2]) + ": give 1 in two dimensions");
    if (options.columns == 0 || options.columns > max_columns)
        refuse_grid("columns = " + std::to_string(options.columns) + " is not from 1 to " +
                    std::to_string(max_columns));
    const std::size_t cells = count_grid_cells(options);
    if (cells > max_numbers / options.columns)
        throw Error(ErrorCode::out_of_memory,
                    "to_grid(): " + std::to_string(cells) + " grid cells do not fit into memory: give a smaller shape");
    if (grid.size() / options.columns != cells || grid.size() % options.columns != 0)
        refuse_grid("the grid holds " + std::to_string(grid.size()) + " numbers, its shape needs " +
                    std::to_string(cells) + " for each of " + std::to_string(options.columns) + " columns");
    if (values.size() != seeds * options.columns)
        refuse_grid("there are " + std::to_string(values.size()) + " values, " + std::to_string(seeds) +
                    " seeds need " + std::to_string(options.columns) + " each");
}

// The cells of the seeds, with faces.
Result build(const DiagramState& state) {
    Settled run = run_in(state, state.job.region);
    run.want = {};
    run.want.faces = true;
    run.list_walls = false;
    run.progress = Stoppable::within({0, share_of_building});
    return arrays_of(std::move(run));
}

// Returns the centers of grid cells, at z = 0 exactly in a sheet.
std::vector<double> on_plane(const DiagramState& state, std::span<const double> centers) {
    std::vector<double> places(centers.begin(), centers.end());
    for (std::size_t i = 2; i < places.size() && state.planar(); i += 3) places[i] = 0;
    return places;
}

// The parts of the cells in the mesh. around: in the domain of the grid.
Pieces build_pieces(const DiagramState& state, const DiagramState& around) {
    const solid::MeshArrays mesh(*state.inside->mesh(), state.job.scale);
    Settled run = run_in(around, around.job.region);
    run.region.mesh = mesh.view();
    run.want = {};
    run.progress = Stoppable::within({0, share_of_building});
    PieceOptions wanted;
    wanted.threads = run.threads;
    return pieces(tessellate(std::move(run)), wanted);
}

void locate_centers(DiagramState& state, const fields::Task& task, std::span<const double> centers,
                    std::span<double> field) {
    const std::vector<std::int32_t> seeds = locate_in_domain(state, {on_plane(state, centers), {}});
    const std::size_t m = task.columns;
    for (std::size_t q = 0; q < seeds.size(); ++q)
        if (seeds[q] >= 0) std::copy_n(&task.values[static_cast<std::size_t>(seeds[q]) * m], m, &field[q * m]);
}

void interpolate_centers(DiagramState& state, const fields::Task& task, std::span<const double> centers,
                         std::span<double> field) {
    const std::vector<double> places = on_plane(state, centers);
    std::ranges::copy(interpolate_in_domain(state, task.values, task.columns, places, {}).values, field.begin());
    // The field is 0 beyond walls.
    std::vector<double> unknown;
    std::vector<std::size_t> rows;
    for (std::size_t q = 0; 3 * q < places.size(); ++q) {
        if (!std::isnan(field[q * task.columns])) continue;
        rows.push_back(q);
        for (std::size_t k = 0; k < 3; ++k) unknown.push_back(places[3 * q + k]);
    }
    const std::vector<std::int32_t> seeds = locate_in_domain(state, {unknown, {}});
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (seeds[i] < 0) std::ranges::fill(field.subspan(rows[i] * task.columns, task.columns), 0.0);
}

}  // namespace

std::size_t to_grid(DiagramState& state_of_call, std::span<const double> values, const GridOptions& options,
                    std::span<double> grid) {
    check(state_of_call, values, options, grid);
    if (state_of_call.inside && options.method == GridMethod::dtfe)
        throw Error(
            ErrorCode::unsupported,
            "to_grid(): dtfe spreads masses over tetrahedra, which reach beyond a mesh: give another method, or "
            "leave out " +
                option("mesh"));
    in_pieces(grid.size(),
              [&](std::size_t begin, std::size_t end) { std::ranges::fill(grid.subspan(begin, end - begin), 0); });
    if (state_of_call.points.empty()) return 0;
    const std::shared_ptr<DiagramState> around = state_of_call.endless ? state_around(state_of_call) : nullptr;
    DiagramState& state = around ? *around : state_of_call;
    const bool integrates = options.method == GridMethod::mean || options.method == GridMethod::dtfe;
    std::array<std::size_t, 3> shape = options.shape;
    if (options.project && integrates) shape[static_cast<std::size_t>(*options.project)] = 1;  // it needs no steps
    const fields::Frame frame(state.job, shape);
    const fields::Task task{frame, values, options.columns, grid, options.project};
    std::size_t without_place = 0;
    if (state_of_call.inside && options.method == GridMethod::mean) {
        const Pieces pieces = build_pieces(state_of_call, state);
        const CallGuard turn(state);
        Stoppable::enter_stage({share_of_building, 1});
        fields::add_mean(task, pieces, state.clipper.pool());
    } else if (integrates) {
        Result of_space = build(state);
        if (state.planar() && options.method == GridMethod::dtfe)  // the dual is that of the plane
            flatten(of_space, {.volumes = false, .vertices = true, .faces = true}, true);
        const auto result = std::make_shared<const Result>(std::move(of_space));
        const Tessellation cells(result);
        const fields::Built built{state.job, *result, cells};
        const CallGuard turn(state);
        Stoppable::enter_stage({share_of_building, 1});
        if (options.method == GridMethod::mean) fields::add_mean(task, built, state.clipper.pool());
        if (options.method == GridMethod::dtfe) without_place = fields::add_dtfe(task, built, state.clipper.pool());
    } else {
        const auto evaluate = options.method == GridMethod::nearest ? locate_centers : interpolate_centers;
        const std::size_t m = options.columns;
        fields::add_at_centers(task, [&](std::span<const double> centers, std::span<double> field) {
            if (!state_of_call.inside) return evaluate(state, task, centers, field);
            const Queries all{{centers.begin(), centers.end()}, {}};
            const std::vector<std::int32_t> numbers = in_mesh(state_of_call, all);
            std::vector<double> inside(numbers.size() * m);
            evaluate(state, task, some_of(all.x, numbers, 3), inside);
            for (std::size_t k = 0; k < numbers.size(); ++k)
                std::copy_n(&inside[k * m], m, &field[static_cast<std::size_t>(numbers[k]) * m]);
        });
    }
    if (options.project && options.method != GridMethod::dtfe) {
        const fields::Axis& axis = frame.axis(static_cast<std::size_t>(*options.project));
        const double length = axis.length / static_cast<double>(axis.count);
        in_pieces(grid.size(), [&](std::size_t begin, std::size_t end) {
            for (double& x : grid.subspan(begin, end - begin)) x *= length;
        });
    }
    return without_place;
}

}  // namespace votess::detail

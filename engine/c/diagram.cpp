// Diagrams and their queries.
#include <algorithm>
#include <limits>

#include "c/handles.hpp"

using namespace votess::c;

namespace {

static_assert(same(VOTESS_GRID_MEAN, votess::GridMethod::mean));
static_assert(same(VOTESS_GRID_DTFE, votess::GridMethod::dtfe));
static_assert(same(VOTESS_GRID_NEAREST, votess::GridMethod::nearest));
static_assert(same(VOTESS_GRID_SIBSON, votess::GridMethod::sibson));

// Returns the size of the grid; the largest array there can be if it overflows.
std::size_t size_of(const votess::GridOptions& options) {
    constexpr std::size_t max = std::numeric_limits<std::size_t>::max() / sizeof(double);
    std::size_t size = options.columns;
    for (int k = 0; k < 3; ++k) {
        const std::size_t along = k == options.project ? 1 : options.shape[static_cast<std::size_t>(k)];
        size = along > 0 && size > max / along ? max : size * along;
    }
    return size;
}

}  // namespace

votess_status votess_diagram_new(const double* points, size_t count, const votess_options* options,
                                 votess_diagram** out) {
    return create(out, [&] {
        const votess::Options converted = convert_options(options, count);
        const auto input = coordinates(points, count, "points", "count", dimensions_of(converted));
        return votess_diagram{votess::Diagram(input, converted), {}};
    });
}

votess_status votess_diagram_view(const votess_diagram* diagram, const votess_options* options, votess_diagram** out) {
    return create(out, diagram, "diagram", [&](auto& of) {
        return votess_diagram{of.diagram, convert_options(options, 0).progress};
    });
}

size_t votess_diagram_size(const votess_diagram* diagram) {
    return value_of<std::size_t>(diagram, "diagram is NULL",
                                 [](const votess_diagram& of) { return of.diagram.size(); });
}

int votess_diagram_planar(const votess_diagram* diagram) {
    return value_of<int>(diagram, "diagram is NULL", [](const votess_diagram& of) { return of.diagram.planar(); });
}

votess_status votess_diagram_locate(const votess_diagram* diagram, const double* queries, size_t count,
                                    int32_t* seeds) {
    return guarded(diagram, "diagram", [&](auto& of) {
        const auto input = queries_of(of, queries, count);
        require_array(seeds, count, "seeds", "count");
        std::ranges::copy(of.diagram.locate(input, of.progress), seeds);
    });
}

votess_status votess_diagram_probe(const votess_diagram* diagram, const double* queries, size_t count, uint32_t want,
                                   int32_t list_walls, const double* weights, votess_result** out) {
    return create(out, diagram, "diagram", [&](auto& of) {
        const auto input = queries_of(of, queries, count);
        votess::ProbeOptions options;
        options.want = convert_want(want, "want");
        options.list_walls = list_walls != 0;
        options.progress = of.progress;
        if (weights != nullptr) options.weights = {weights, count};
        return votess_result{of.diagram.probe(input, options)};
    });
}

votess_status votess_diagram_to_grid(const votess_diagram* diagram, const double* values, size_t columns,
                                     const size_t shape[3], int32_t method, int32_t project, double* grid,
                                     size_t* without_place) {
    return guarded(diagram, "diagram", [&](auto& of) {
        require(shape, "shape");
        require(grid, "grid");
        const std::size_t seeds = of.diagram.size();
        if (seeds > 0) require(values, "values");
        votess::GridOptions options{{shape[0], shape[1], shape[2]}, static_cast<votess::GridMethod>(method), columns};
        if (project != -1) options.project = project;
        options.progress = of.progress;
        const std::size_t without = of.diagram.to_grid({values, seeds * columns}, options, {grid, size_of(options)});
        if (without_place != nullptr) *without_place = without;
    });
}

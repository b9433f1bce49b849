#include "run/cells.hpp"

#include <array>
#include <utility>
#include <votess/fit.hpp>

#include "arguments/carried.hpp"
#include "arguments/only.hpp"
#include "picture.hpp"
#include "run/settle.hpp"

namespace clvotess {
namespace {

votess::AlphaComplex alpha_of(const Arguments& arguments, const votess::Tessellation& tessellation,
                              std::span<const double> points) {
    const std::int32_t n = arguments.alpha;
    const auto& periodic = tessellation.periodic();
    std::array<std::int32_t, 3> copies{n, n, tessellation.planar() ? 1 : n};
    const bool any = periodic != std::array<bool, 3>{};
    for (std::size_t k = 0; k < 3 && any; ++k)
        if (!periodic[k]) copies[k] = 1;
    return votess::alpha_complex(tessellation, points, copies);
}

// Keeps the rows of some points.
void keep(const std::vector<std::int64_t>& only, Cells& cells) {
    for (InputColumn& column : cells.carried) column = rows_of(column, only);
    if (!cells.radii.empty()) {
        cells.radii_of_rows = rows_of({"radii", 1, {cells.radii.begin(), cells.radii.end()}}, only);
        cells.radii = cells.radii_of_rows.values;
    }
    cells.all_ids = cells.input.ids;
    cells.input = points_of(cells.input, only);
}

}  // namespace

OutputData Cells::output(const Arguments& arguments, FramePlace place) const {
    const bool alone = place == FramePlace::alone;
    return {.input = input,
            .tessellation = tessellation,
            .wanted = arguments.wanted,
            .format = arguments.format,
            .radii = radii,
            .domain_from = domain_from,
            .carried = carried,
            .coloring = arguments.coloring,
            .reports_size = alone && !arguments.quiet,
            .threads = alone ? arguments.options.threads : 1,
            .place = place,
            .has_radii = arguments.has_radii,
            .all_ids = all_ids,
            .gap = arguments.gap,
            .min_edge = arguments.min_edge,
            .alpha = alpha ? &*alpha : nullptr,
            .skip_open = arguments.skip_open};
}

Cells make_cells(const Arguments& arguments, Input input, votess::Tessellator* tessellator, const Watch& watch) {
    Settled run = settle(arguments, std::move(input));
    votess::Options& options = run.options;
    const std::vector<double>& points = run.input.points;
    if (arguments.hull)
        watch([&](const votess::ProgressCallback& callback) {
            options.progress = callback;
            set_hull(points, options);
            options.progress = {};
            return 0;
        });
    std::vector<std::int64_t> only;
    if (!arguments.only.empty()) options.only = only = read_only(arguments.only, run.input.size());
    // Faces for a picture add walls to the rows. An output without --list-walls then needs a second run.
    const bool once = !arguments.picture || options.list_walls || arguments.outputs.empty() || options.mesh;
    votess::Options for_picture = options;
    if (arguments.picture) {
        for_picture.want.faces = !options.mesh;
        arguments.coloring.add_needs(for_picture.want);
    }
    const auto tessellate = [&](votess::Options with) {
        return watch([&](const votess::ProgressCallback& callback) {
            with.progress = callback;
            return tessellator ? tessellator->tessellate(std::span<const double>(points), with)
                               : votess::tessellate(std::span<const double>(points), with);
        });
    };

    Cells cells;
    votess::VolumeFit fit;
    if (arguments.has_volumes) {
        fit = watch([&](const votess::ProgressCallback& callback) {
            votess::Options watched = once ? for_picture : options;
            watched.progress = callback;
            return votess::fit_volumes(points, targets_of(arguments, run.input), watched, arguments.fit);
        });
        cells.fit = Summary::Fit{fit.steps, fit.residual};
        cells.tessellation = std::move(fit.tessellation);
        fill_weights(arguments, fit.weights, run.carried);
        for_picture.weights = fit.weights;
        for_picture.radii = {};
    } else {
        cells.tessellation = tessellate(once ? for_picture : options);
    }
    const votess::Tessellation& tessellation = cells.tessellation;
    std::vector<double> masses = masses_of(arguments, run.input);
    merge_masses(tessellation.duplicate_of(), masses);
    fill_density(arguments, masses, tessellation.volumes(), run.carried);
    watch([&](const votess::ProgressCallback&) {
        fill_zones(arguments, run.input, tessellation, run.carried);
        if (arguments.alpha > 0) cells.alpha = alpha_of(arguments, tessellation, points);
        if (arguments.verify) cells.verified = votess::verify(tessellation, points);
        return 0;
    });
    if (arguments.picture && !cells.failed()) {
        const auto began = Clock::now();
        cells.image = draw_picture(*arguments.picture, arguments.coloring, run.input,
                                   once ? tessellation : tessellate(for_picture), run.carried, arguments.gap);
        cells.image_seconds = seconds_since(began);
    }

    cells.domain_from = run.domain_from;
    cells.radii = options.radii;
    cells.carried = std::move(run.carried);
    cells.input = std::move(run.input);
    if (options.only) keep(only, cells);
    return cells;
}

}  // namespace clvotess

#include "votess/diagram.hpp"

#include "core/errors.hpp"
#include "core/progress.hpp"
#include "diagram/diagram_state.hpp"
#include "input/option_name.hpp"
#include "plane/sheet.hpp"

namespace votess {

namespace {

using detail::DiagramState, detail::in_space;

// Runs a call that the user may stop. Reports its beginning and its end, and a failure to get memory as an Error.
template <class Work>
auto run(const ProgressCallback& callback, const Work& work) {
    try {
        Progress progress(callback);
        const Stoppable stoppable(progress, {});
        progress.report(0);
        auto result = work();
        progress.report(1);
        return result;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, "out of memory: take fewer seeds, or ask with fewer queries at once");
    }
}

void check_diagram(const Settled& run) {
    if (run.device != "cpu" && run.device != "auto")
        throw Error(ErrorCode::unsupported,
                    option("device") + " = " + run.device + ": a Diagram is asked on the CPU, give cpu or auto");
    if (run.min_face != 0 || run.min_area != 0)
        refuse(option("min_face") + " and " + option("min_area") +
               " drop faces of a result: a Diagram has whole cells, leave them out");
    if (run.subset) refuse("a Diagram needs all seeds: leave out " + option("only") + ", and probe some places");
}

Tessellation probe_in(DiagramState& state, std::span<const double> queries, const ProbeOptions& options) {
    std::vector<double> places = in_space(state, queries, "queries");
    if (!state.planar())
        return Tessellation(std::make_shared<const detail::Result>(detail::probe(state, std::move(places), options)));
    ProbeOptions of_sheet = options;
    add_sheet_wants(of_sheet.want, of_sheet.list_walls);
    detail::Result cells = detail::probe(state, std::move(places), of_sheet);
    flatten(cells, with_implied(options.want), options.list_walls || options.want.faces);
    return Tessellation(std::make_shared<const detail::Result>(std::move(cells)));
}

}  // namespace

std::shared_ptr<DiagramState> detail::make_state(const ProgressCallback& progress,
                                                 const std::function<Settled()>& settle) {
    return run(progress, [&] {
        Settled whole = settle();
        check_diagram(whole);
        return make_state(std::move(whole));
    });
}

std::size_t Diagram::size() const noexcept {
    return state_->points.size() / 3;
}
bool Diagram::planar() const noexcept {
    return state_->planar();
}

std::vector<std::int32_t> Diagram::locate(std::span<const double> queries, const ProgressCallback& progress) const {
    return run(progress, [&] {
        return detail::locate(*state_, detail::check_queries(*state_, in_space(*state_, queries, "queries")));
    });
}

RayCells Diagram::trace(std::span<const double> origins, std::span<const double> directions,
                        std::span<const double> lengths, const TraceOptions& options) const {
    return run(options.progress, [&] {
        RayCells cells = detail::trace(*state_, in_space(*state_, origins, "origins"),
                                       in_space(*state_, directions, "directions"), lengths, options.middles);
        cells.planar = planar();
        if (planar()) cells.middles = out_of_sheet(cells.middles);
        return cells;
    });
}

Tessellation Diagram::probe(std::span<const double> queries, const ProbeOptions& options) const {
    return run(options.progress, [&] { return probe_in(*state_, queries, options); });
}

NaturalCoordinates Diagram::natural_neighbors(std::span<const double> queries, const NaturalOptions& options) const {
    return run(options.progress, [&] {
        NaturalCoordinates found = detail::natural_neighbors(*state_, in_space(*state_, queries, "queries"), options);
        if (planar()) found.gradients = out_of_sheet(found.gradients);
        return found;
    });
}

Interpolated Diagram::interpolate(std::span<const double> values, std::size_t components,
                                  std::span<const double> queries, const NaturalOptions& options) const {
    return run(options.progress, [&] {
        Interpolated found =
            detail::interpolate(*state_, values, components, in_space(*state_, queries, "queries"), options);
        if (planar()) found.gradients = out_of_sheet(found.gradients);
        return found;
    });
}

std::size_t Diagram::to_grid(std::span<const double> values, const GridOptions& options, std::span<double> grid) const {
    return run(options.progress, [&] { return detail::to_grid(*state_, values, options, grid); });
}

Tessellation Diagram::grid_domain() const {
    return run({}, [&] { return probe_in(state_->endless ? *detail::state_around(*state_) : *state_, {}, {}); });
}

}  // namespace votess

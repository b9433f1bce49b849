#include "votess/diagram.hpp"

#include <limits>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "diagram/diagram_state.hpp"
#include "unbounded/endless_box.hpp"

namespace votess {

namespace {

using detail::DiagramState;

constexpr Box no_ends{{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};

// Runs a call that the user may stop. Reports its beginning and its end, and a failure to get memory as an Error.
template <class Work>
auto run(const ProgressCallback& callback, const Work& work) {
    try {
        Progress progress(callback);
        const Stoppable stoppable(progress);
        progress.report(0);
        auto result = work();
        progress.report(1);
        return result;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, "out of memory: take fewer seeds, or ask with fewer queries at once");
    }
}

// Without a domain the seeds are in all of space.
std::shared_ptr<DiagramState> new_state(std::span<const double> points, const Options& options) {
    if (options.device != "cpu" && options.device != "auto")
        throw Error(ErrorCode::unsupported,
                    "Options::device = " + options.device + ": a Diagram is asked on the CPU, give cpu or auto");
    if (options.min_face != 0 || options.min_area != 0)
        throw Error(ErrorCode::invalid_argument,
                    "Options::min_face and Options::min_area drop faces of a result: a Diagram has whole cells, leave "
                    "them out");
    if (options.only)
        throw Error(ErrorCode::invalid_argument,
                    "a Diagram needs all seeds: leave out Options::only, and probe some places");
    if (points.size() / 3 > std::numeric_limits<std::int32_t>::max())
        throw Error(ErrorCode::unsupported,
                    std::to_string(points.size() / 3) + " seeds are too many: at most 2147483647");
    const bool periodic = options.periodic != std::array<bool, 3>{};
    std::optional<Box> endless;
    if (EndlessSides(options.box).any()) {
        check_endless(options);
        endless = options.box;
    } else if (!options.box && !options.cell && !periodic && options.walls.empty()) {
        endless = no_ends;
    }
    if (!endless) return detail::make_state(points, options);
    if (endless->lower != no_ends.lower || endless->upper != no_ends.upper)
        throw Error(ErrorCode::unsupported,
                    "a Diagram needs a box with all of its ends, or with none: give the same for all sides");
    Options near = options;
    near.box = near_box({points, {}}, *endless);
    std::shared_ptr<DiagramState> state = detail::make_state(points, near);
    state->endless = endless;
    return state;
}

}  // namespace

Diagram::Diagram() : Diagram(std::span<const double>{}) {}
Diagram::Diagram(std::span<const double> points, const Options& options)
    : state_(run(options.progress, [&] { return new_state(points, options); })) {}

std::size_t Diagram::size() const noexcept {
    return state_->points.size() / 3;
}

std::vector<std::int32_t> Diagram::locate(std::span<const double> queries, const ProgressCallback& progress) const {
    return run(progress, [&] { return detail::locate(*state_, detail::check_queries(*state_, queries)); });
}

RayCells Diagram::trace(std::span<const double> origins, std::span<const double> directions,
                        std::span<const double> lengths, const TraceOptions& options) const {
    return run(options.progress, [&] { return detail::trace(*state_, origins, directions, lengths, options.middles); });
}

Tessellation Diagram::probe(std::span<const double> queries, const ProbeOptions& options) const {
    return run(options.progress, [&] { return detail::probe(*state_, queries, options); });
}

NaturalCoordinates Diagram::natural_neighbors(std::span<const double> queries, const NaturalOptions& options) const {
    return run(options.progress, [&] { return detail::natural_neighbors(*state_, queries, options); });
}

Interpolated Diagram::interpolate(std::span<const double> values, std::size_t components,
                                  std::span<const double> queries, const NaturalOptions& options) const {
    return run(options.progress, [&] { return detail::interpolate(*state_, values, components, queries, options); });
}

std::size_t Diagram::to_grid(std::span<const double> values, const GridOptions& options, std::span<double> grid) const {
    return run(options.progress, [&] { return detail::to_grid(*state_, values, options, grid); });
}

}  // namespace votess

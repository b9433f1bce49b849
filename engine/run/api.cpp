#include <atomic>
#include <utility>
#include <vector>

#include "core/one_call.hpp"
#include "core/progress.hpp"
#include "input/domain_of_result.hpp"
#include "input/settle.hpp"
#include "input/settled.hpp"
#include "plane/sheet.hpp"
#include "result/handle.hpp"
#include "result/result_pool.hpp"
#include "run/engines.hpp"
#include "solid/run_in_mesh.hpp"
#include "unbounded/endless_box.hpp"
#include "unbounded/run_endless.hpp"
#include "votess/votess.hpp"

namespace votess {
namespace detail {
struct TessellatorState {
    std::atomic_flag at_work;
    Engines engines;
    std::shared_ptr<ResultPool> results = std::make_shared<ResultPool>();
};
}  // namespace detail

Tessellation::Tessellation() : Tessellation(nullptr) {}
Tessellation::Tessellation(std::shared_ptr<const detail::Result> result) : result_(std::move(result)) {
    (void)detail::result_of(*this);  // here it may throw, in an accessor not
}

std::size_t Tessellation::size() const noexcept {
    return detail::result_of(*this).status.size();
}
std::span<const std::int32_t> Tessellation::neighbors(std::size_t i) const noexcept {
    const auto& p = detail::result_of(*this).indptr;
    if (i + 1 >= p.size()) return {};
    return std::span<const std::int32_t>(detail::result_of(*this).indices)
        .subspan(static_cast<std::size_t>(p[i]), static_cast<std::size_t>(p[i + 1] - p[i]));
}
// A member of the result, under the same name.
#define VOTESS_MEMBER(name, ...)                            \
    auto Tessellation::name() const noexcept->__VA_ARGS__ { \
        return detail::result_of(*this).name;               \
    }
#define VOTESS_ROW_ARRAY(name, type, ...) VOTESS_MEMBER(name, std::span<const type>)
#define VOTESS_ROW_STARTS(name, type, ...) VOTESS_MEMBER(name, std::span<const type>)
#define VOTESS_OTHER_ARRAY(name, type, ...) VOTESS_MEMBER(name, std::span<const type>)
#include "votess/arrays.h"
VOTESS_MEMBER(walls, std::span<const Wall>)
VOTESS_MEMBER(least_face, double)
VOTESS_MEMBER(box, const Box&)
VOTESS_MEMBER(periodic, const std::array<bool, 3>&)
VOTESS_MEMBER(cell, const std::optional<TriclinicBox>&)
VOTESS_MEMBER(planar, bool)
VOTESS_MEMBER(lists_walls, bool)
VOTESS_MEMBER(is_subset, bool)
VOTESS_MEMBER(probed, bool)
VOTESS_MEMBER(stats, const Stats&)
#undef VOTESS_MEMBER

bool Tessellation::in_mesh() const noexcept {
    return detail::result_of(*this).mesh_cells != nullptr;
}

Tessellator::Tessellator() : state_(std::make_shared<detail::TessellatorState>()) {}
Tessellator::~Tessellator() = default;
Tessellator::Tessellator(Tessellator&&) noexcept = default;
Tessellator& Tessellator::operator=(Tessellator&&) noexcept = default;

namespace {

// In space. arrays: memory of an earlier result to use again.
detail::Result run_in_space(Engines& engines, Settled whole, detail::Result arrays) {
    const auto run = [&](Settled part) { return run_on(engines, std::move(part), std::exchange(arrays, {})); };
    if (!whole.region.mesh && !EndlessSides(whole.region).any()) return run(std::move(whole));
    // All parts of the run read the same copy.
    std::vector<double> copy(whole.points.coordinates());
    for (std::size_t i = 0; i < copy.size(); ++i) copy[i] = whole.points[i];
    whole.points = {copy, {}};
    return whole.region.mesh ? solid::run_in_mesh(whole, run) : run_endless(whole, run);
}

detail::Result run_anywhere(Engines& engines, Settled whole, detail::Result arrays) {
    imply(whole);
    if (!whole.region.planar) return run_in_space(engines, std::move(whole), std::move(arrays));
    Sheet sheet(std::move(whole));
    detail::Result result = run_in_space(engines, sheet.take_in_space(), std::move(arrays));
    sheet.flatten(result);
    return result;
}

// shared: outlives a Tessellator that a callback destroys, and is not destroyed in a child that fork() makes meanwhile.
// settled: makes the run.
Tessellation run(std::shared_ptr<detail::TessellatorState> shared, std::size_t seeds, const auto& settled) {
    if (!shared) throw Error(ErrorCode::invalid_use, "this Tessellator was moved from: it can only be assigned to");
    detail::TessellatorState& state = *shared;
    const OneCall turn(state.at_work,
                       "this Tessellator is in use by another call, or was when fork() made this process: use one "
                       "for each thread, and none of them in its own callbacks");
    const auto out_of_memory = [seeds] {
        return Error(ErrorCode::out_of_memory, "out of memory while tessellating " + std::to_string(seeds) + " seeds");
    };
    try {
        Settled whole = settled();
        const LogCallback log = whole.log;
        // Its fractions never fall, whichever engines and parts of the run report them.
        Progress progress(whole.progress);
        whole.progress = progress.within({0, 1});
        auto result = state.results->share(run_anywhere(state.engines, std::move(whole), state.results->take()));
        progress.report(1);
        const Stats& s = result->stats;
        if (log)
            log("tessellated " + std::to_string(s.points) + " seeds on " + s.device + " in " +
                std::to_string(s.seconds.total) + " s");
        return Tessellation(std::move(result));
    } catch (const std::bad_alloc&) {
        throw out_of_memory();
    } catch (const std::length_error&) {
        throw out_of_memory();
    }
}

}  // namespace

Tessellation Tessellator::tessellate(std::span<const double> points, const Options& options) {
    return run(state_, points.size() / (options.planar ? 2 : 3), [&] { return settle({points, {}}, options); });
}
Tessellation Tessellator::tessellate(std::span<const float> points, const Options& options) {
    return run(state_, points.size() / (options.planar ? 2 : 3), [&] { return settle({{}, points}, options); });
}

Tessellation tessellate(std::span<const double> points, const Options& options) {
    return Tessellator().tessellate(points, options);
}
Tessellation tessellate(std::span<const float> points, const Options& options) {
    return Tessellator().tessellate(points, options);
}

Runner::Runner() : state_(std::make_shared<detail::TessellatorState>()) {}
Tessellation Runner::operator()(Settled whole) {
    return run(state_, whole.points.coordinates() / (whole.region.planar ? 2 : 3), [&] { return std::move(whole); });
}
detail::Result arrays_of(Settled whole) {
    Engines engines;
    return run_anywhere(engines, std::move(whole), {});
}

Want implied_want(const Options& options) {
    const Settled run = settle(options);
    if (run.region.mesh) {
        solid::check_want(run.want);
        std::optional<Prism> prism;
        (void)solid::ClosedMesh(run.region.planar ? prism.emplace(*run.region.mesh, 1).view() : *run.region.mesh);
    }
    return run.want;
}

std::vector<double> wrapped_points(const Tessellation& t, std::span<const double> points) {
    // A subset does not know how many points there were.
    if (!t.is_subset()) require_finite_points(t, points, "wrapped_points");
    const std::vector<double> copy(points.begin(), points.end());  // read once, see input/snapshot.hpp
    std::vector<double> wrapped = copy;
    if (t.periodic() == std::array<bool, 3>{}) return wrapped;
    Settled run;
    run.points = {copy, {}};
    run.region = region_of(t);
    check_shape(run.points, t.planar());
    std::optional<Sheet> sheet;
    if (t.planar()) run = sheet.emplace(std::move(run)).in_space();
    if (EndlessSides(run.region).any()) end_near(run.region, run.points);
    std::vector<double> moved(run.points.f64.begin(), run.points.f64.end());
    move_into_domain(make_job(std::move(run)), moved);
    const std::size_t dimensions = t.planar() ? 2 : 3;
    for (std::size_t i = 0; i < wrapped.size(); ++i) wrapped[i] = moved[i / dimensions * 3 + i % dimensions];
    return wrapped;
}

std::vector<DeviceInfo> devices() {
    return Engines::devices();
}

}  // namespace votess

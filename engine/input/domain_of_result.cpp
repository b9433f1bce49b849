#include "input/domain_of_result.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "input/settle.hpp"
#include "result/handle.hpp"

namespace votess {
namespace {

constexpr std::size_t seeds_per_stop_check = 1024;

}  // namespace

Region region_of(const Tessellation& t) {
    Region region;
    if (t.cell())
        region.cell = t.cell();
    else
        region.box = t.box(), region.periodic = t.periodic();
    region.walls.assign(t.walls().begin(), t.walls().end());
    region.planar = t.planar();
    region.thickness = detail::result_of(t).thickness;
    const bool dropped = std::ranges::find(t.status(), CellStatus::outside) != t.status().end();
    region.outside = dropped ? Outside::drop : Outside::keep;
    return region;
}

Settled run_of(const Tessellation& t, std::span<const double> points) {
    Settled run;
    run.points = {points, {}};
    run.region = region_of(t);
    run.weights.given.assign(t.weights().begin(), t.weights().end());
    run.device = "cpu";
    return run;
}

void require_points(const Tessellation& t, std::span<const double> points, const std::string& function) {
    if (points.size() == (t.planar() ? 2 : 3) * t.size()) return;
    refuse(function + "(): points hold " + std::to_string(points.size()) + " coordinates, the result has " +
           std::to_string(t.size()) + " cells");
}

void require_finite_points(const Tessellation& t, std::span<const double> points, const std::string& function) {
    require_points(t, points, function);
    const std::size_t dimensions = t.planar() ? 2 : 3;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!std::isfinite(points[i]))
            refuse(function + "(): point " + std::to_string(i / dimensions) + ": " + "xyz"[i % dimensions] + " = " +
                   number(points[i]) + " is not finite: give the points of the result");
}

void move_into_domain(const Job& job, std::span<double> places) {
    const Domain& domain = *job.domain;
    if (!domain.is_periodic()) return;
    for (std::size_t i = 0; i < job.points.count(); ++i) {
        if (i % seeds_per_stop_check == 0) check_stop();
        if (!job.outside.empty() && job.outside[i] == CellStatus::outside) continue;
        const exact::Point x{places[3 * i] * job.scale, places[3 * i + 1] * job.scale, places[3 * i + 2] * job.scale};
        const auto shift = wrap(domain, x);
        if (!shift || *shift == exact::Shift{}) continue;
        const auto at = exact::differences({}, exact::Plane::bisector(x, *shift, domain.lattice)).x;
        for (std::size_t k = 0; k < 3; ++k) places[3 * i + k] = at[k].high / job.scale;
    }
}

}  // namespace votess

#include "fit/fit_volumes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <optional>
#include <utility>

#include "core/progress.hpp"
#include "core/sum.hpp"
#include "core/text.hpp"
#include "core/thread_pool.hpp"
#include "fields/masses.hpp"
#include "fit/newton.hpp"
#include "fit/smooth_start.hpp"
#include "fit/timed.hpp"
#include "index/sort.hpp"
#include "input/domain_of_result.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "input/snapshot.hpp"
#include "plane/sheet.hpp"
#include "solid/run_in_mesh.hpp"

namespace votess {

FitError::FitError(const std::string& message, std::vector<double> weights, double residual, unsigned steps)
    : Error(ErrorCode::not_converged, message), weights_(std::move(weights)), residual_(residual), steps_(steps) {}
FitError::~FitError() = default;

namespace fit {
namespace {

constexpr double sum_tolerance = 1e-9;

[[noreturn]] void refuse(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, "fit_volumes(): " + message);
}

void check(const Settled& run, const FitOptions& fit) {
    if (!(fit.tolerance > 0) || !std::isfinite(fit.tolerance))
        refuse("FitOptions::tolerance is " + number(fit.tolerance) + ": it must be positive and finite");
    if (run.subset) refuse("a fit needs all cells: leave out " + option("only"));
    if (fit.density && run.region.mesh)
        refuse("FitOptions::density: masses of cells in a mesh are not supported, leave out " + option("mesh") +
               " or make the density 0 outside of it");
    if (EndlessSides(run.region).any())
        refuse(option("box") + ": cells that reach infinity have no volume, give a box with ends");
}

bool is_dropped(const Job& job, std::size_t i) {
    return !job.outside.empty() && job.outside[i] == CellStatus::outside;
}

// Returns the targets so that they sum to the volume of the domain, or to its mass. Those of dropped points do not
// count.
std::vector<double> checked_targets(const Job& job, std::span<const double> given, double volume,
                                    const FitOptions& options) {
    const std::size_t count = job.points.count();
    if (given.size() != count)
        refuse(std::to_string(given.size()) + " target volumes for " + std::to_string(count) +
               " points: give one for each");
    std::vector<double> targets(given.begin(), given.end());
    Sum sum;
    for (std::size_t i = 0; i < count; ++i) {
        if (is_dropped(job, i)) continue;
        if (!(targets[i] > 0) || !std::isfinite(targets[i]))
            refuse("the target volume of point " + std::to_string(i) + " is " + number(targets[i]) +
                   ": it must be positive and finite; leave out points that shall have no cell");
        sum += targets[i];
    }
    const double total = sum.value();
    if (!options.normalize && !(std::abs(total - volume) <= sum_tolerance * volume))
        refuse("the target volumes sum to " + number(total) + ", but the domain has " +
               (options.density ? "the mass " : "") + number(volume) +
               ": correct them, or set FitOptions::normalize to scale them to that sum");
    for (double& target : targets) target *= volume / total;
    return targets;
}

Edges edges_of(const Job& job) {
    if (const auto& cell = job.region.cell) return {cell->a, cell->b, cell->c};
    Edges edges{};
    for (std::size_t k = 0; k < 3; ++k) edges[k][k] = job.box.upper[k] - job.box.lower[k];
    return edges;
}

// Returns the indices of the places along a Hilbert curve, without dropped points.
std::vector<std::int32_t> order_of(const Job& job, std::span<const double> places, ThreadPool& pool) {
    cpu::SeedSorter sorter;
    cpu::SortedSeeds seeds;
    sorter.sort(places, job.scale, job.grid_resolution, pool, seeds);
    if (seeds.duplicates > 0) {  // refuses those that are not equal by rounding alone
        Settled run = job;
        run.want = {};
        run.duplicates = Duplicates::error;
        run.progress = Stoppable::within({});
        (void)tessellate(std::move(run));
    }
    std::vector<std::int32_t> order(seeds.input.begin(), seeds.input.begin() + seeds.size());
    for (std::size_t i = 0; i < seeds.duplicate_of.size(); ++i)
        if (seeds.duplicate_of[i] >= 0) order.push_back(static_cast<std::int32_t>(i));
    std::erase_if(order, [&](std::int32_t i) { return is_dropped(job, static_cast<std::size_t>(i)); });
    return order;
}

// Returns the whole domain, the cell of a seed in its middle.
Tessellation whole_domain(const Job& job) {
    Settled run = job;
    run.progress = Stoppable::within({});
    run.want = {.neighbors = false, .volumes = true, .centroids = true};
    run.want.faces = true;
    run.weights = {};
    run.min_face = run.min_area = 0;
    if (!run.region.cell) run.region.box = job.box;
    run.region.outside = Outside::keep;
    std::array<double, 3> middle{};
    for (std::size_t k = 0; k < 3; ++k) middle[k] = 0.5 * job.box.lower[k] + 0.5 * job.box.upper[k];
    run.points = {middle, {}};
    return tessellate(std::move(run));
}

// Returns weights with which each point has a cell, also where some lie outside of a domain without periods. Let t and
// c be such that all c + t (p - c) are inside. The Voronoi diagram of these is the power diagram of the points p with
// the weights (1 - t) |p - c|^2. 0 by default.
Vector first_weights(const Job& job, std::span<const std::int32_t> order) {
    Vector weights = Vector::Zero(static_cast<Eigen::Index>(order.size()));
    if (job.beyond.empty() || job.domain->is_periodic()) return weights;
    const Tessellation whole = whole_domain(job);
    const auto center = whole.centroids();
    Settled run = job;
    run.progress = Stoppable::within({});
    if (!run.region.cell) run.region.box = job.box;
    run.want = {.neighbors = false, .volumes = false};
    run.region.outside = Outside::drop;
    const auto all_inside = [&](double t) {
        std::vector<double> moved;
        for (const std::int32_t i : order)
            for (std::size_t k = 0; k < 3; ++k)
                moved.push_back(center[k] + t * (job.points[3 * static_cast<std::size_t>(i) + k] - center[k]));
        run.points = {moved, {}};
        return make_job(run).outside.empty();
    };
    double t = 0.5;
    while (t > 0 && !all_inside(t)) t *= 0.5;
    for (std::size_t row = 0; row < order.size(); ++row)
        for (std::size_t k = 0; k < 3; ++k) {
            const double d = job.points[3 * static_cast<std::size_t>(order[row]) + k] - center[k];
            weights[static_cast<Eigen::Index>(row)] += (1 - t) * d * d;
        }
    return weights;
}

Problem problem_of(const Job& job, const std::optional<TriangleMesh>& mesh, std::span<const double> targets,
                   std::span<const double> places, std::span<const std::int32_t> order, int dimensions) {
    Problem problem;
    problem.given = order;
    problem.scale = job.scale;
    problem.dimensions = dimensions;
    problem.edges = edges_of(job);
    problem.start = first_weights(job, order);
    problem.run = job;
    problem.run.region.mesh = mesh;
    problem.run.list_walls = false;
    problem.run.min_face = problem.run.min_area = 0;
    problem.points.reserve(places.size());
    problem.places.reserve(places.size());
    problem.targets.resize(static_cast<Eigen::Index>(order.size()));
    in_pieces(order.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const auto i = static_cast<std::size_t>(order[row]);
            for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
                problem.points.push_back(job.points[k]);
                problem.places.push_back(places[k]);
            }
            problem.targets[static_cast<Eigen::Index>(row)] = targets[i];
        }
    });
    return problem;
}

// Returns the weights of the caller in this order; 0 by default.
Vector start_of(const Job& job, std::span<const std::int32_t> order) {
    Vector start = Vector::Zero(static_cast<Eigen::Index>(order.size()));
    const std::vector<double>& weights = job.domain->weights;
    for (std::size_t row = 0; row < order.size() && !weights.empty(); ++row)
        start[static_cast<Eigen::Index>(row)] = weights[static_cast<std::size_t>(order[row])] / (job.scale * job.scale);
    return start;
}

// Returns the points with the largest errors, in words.
std::string worst_points(const Vector& errors, std::span<const std::int32_t> order, double tolerance) {
    constexpr std::size_t named = 2;
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < order.size(); ++row)
        if (!(errors[static_cast<Eigen::Index>(row)] <= tolerance)) rows.push_back(row);
    const auto first = rows.begin() + static_cast<std::ptrdiff_t>(std::min(named, rows.size()));
    std::ranges::partial_sort(rows, first, std::ranges::greater(),
                              [&](std::size_t row) { return errors[static_cast<Eigen::Index>(row)]; });
    std::string text = rows.size() == 1 ? "at point" : "at points";
    for (auto row = rows.begin(); row != first; ++row)
        text += (row == rows.begin() ? " " : row + 1 == rows.end() ? " and " : ", ") + std::to_string(order[*row]);
    const auto others = rows.end() - first;
    return others == 0 ? text : text + " and " + std::to_string(others) + (others == 1 ? " other" : " others");
}

// Returns the runner of the last cells.
Runner fit(const Job& job, const std::optional<TriangleMesh>& mesh, std::optional<Under> density,
           std::span<const double> targets, const FitOptions& options, int dimensions, ThreadPool& pool,
           VolumeFit& out) {
    std::vector<double> places(job.points.f64.begin(), job.points.f64.end());
    move_into_domain(job, places);
    const std::vector<std::int32_t> order = order_of(job, places, pool);
    Problem problem = problem_of(job, mesh, targets, places, order, dimensions);
    problem.density = std::move(density);
    problem.pool = &pool;
    Vector start = start_of(job, order);
    if (problem.density && job.domain->weights.empty())
        if (const auto smooth =
                smooth_start(job, *problem.density, problem.places, problem.targets, problem.edges, dimensions, pool))
            start = *smooth;
    Newton newton(std::move(problem), options, out);
    const bool converged = newton.run(std::move(start));
    out.residual = newton.now().residual;
    out.weights.assign(job.points.count(), 0);
    for (std::size_t row = 0; row < order.size(); ++row)
        out.weights[static_cast<std::size_t>(order[row])] = newton.now().weights[static_cast<Eigen::Index>(row)];
    if (converged) return newton.take_runner();
    const std::string message = "fit_volumes: after " + std::to_string(out.steps) + " steps the largest error of a " +
                                (options.density ? "mass" : "volume") + " is " + number(out.residual) +
                                " of its target, more than the tolerance " + number(options.tolerance) + ", " +
                                worst_points(newton.errors(newton.now()), order, options.tolerance) + ": " +
                                newton.why();
    throw FitError(message, std::move(out.weights), out.residual, out.steps);
}

void fit_into(Settled whole, std::span<const double> targets, const FitOptions& options, VolumeFit& out) {
    const Timed total(out.seconds.total);
    Progress progress(whole.progress);
    progress.postpone();  // a refusal of short input comes before any report
    const Stoppable stoppable(progress, {});
    check(whole, options);
    whole.progress = nullptr;
    ThreadPool pool(whole.threads);
    Snapshot snapshot;
    whole.points = snapshot.take(whole.points, pool);
    Settled in_space = whole;
    double mesh_volume = 0;
    std::optional<Sheet> sheet;  // whose weights are those of the plane
    if (whole.region.planar) in_space = sheet.emplace(std::move(in_space)).in_space();
    const std::optional<TriangleMesh> mesh = in_space.region.mesh;
    if (mesh) {
        solid::check_want(whole.want);
        const solid::ClosedMesh closed(*mesh);
        in_space.region = solid::region_around(closed, in_space);
        mesh_volume = volume_in(closed, in_space.region);
    }
    std::vector<double> values;
    if (options.density) values = fields::checked_values(*options.density, whole.region.planar, "fit_volumes", false);
    const Job job = make_job(std::move(in_space));
    const std::size_t count = job.points.count();
    Runner runner;
    if (count > 0) {
        if (std::ranges::count(job.outside, CellStatus::outside) == static_cast<std::ptrdiff_t>(count))
            refuse("all points are outside and dropped: move some into the domain");
        if (!std::isnormal(job.box_volume))
            refuse("the domain is too large or too small for volumes in float64: give lengths in another unit");
        double all = mesh ? mesh_volume : job.box_volume, mean = 1;
        std::optional<Under> density;
        if (options.density) {
            density = Under{fields::Frame(job, options.density->shape), std::move(values)};
            const Masses of = fields::masses_in(whole_domain(job), density->frame, density->values, pool, false);
            all = of.masses[0];
            if (!(all > 0)) refuse("the density is 0 in the whole domain: there is no mass to divide");
            mean = all / job.box_volume;
            if (!std::isnormal(all) || !std::isnormal(mean))
                refuse(
                    "the mass of the domain is too large or too small for float64: give the density in another unit");
            for (double& value : density->values) value /= mean;
        }
        std::vector<double> volumes = checked_targets(job, targets, all, options);
        for (double& volume : volumes) volume /= mean;
        runner = fit(job, mesh, std::move(density), volumes, options, sheet ? 2 : 3, pool, out);
    }
    const Timed last(out.seconds.tessellate);
    whole.weights = {out.weights};
    whole.progress = Stoppable::within({0.95, 1});
    whole.follow = true;
    out.tessellation = runner(std::move(whole));
    ++out.tessellations;
}

}  // namespace

VolumeFit fit_volumes(const std::function<Settled()>& settle, std::size_t seeds, std::span<const double> targets,
                      const FitOptions& options) {
    VolumeFit out;
    try {
        fit_into(settle(), targets, options, out);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory,
                    "out of memory while fitting the volumes of " + std::to_string(seeds) + " seeds");
    }
    return out;
}

}  // namespace fit
}  // namespace votess

#include "fit/newton.hpp"

#include <algorithm>
#include <cmath>

#include "core/at.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "fit/fewer_seeds.hpp"
#include "fit/revive.hpp"
#include "fit/timed.hpp"

namespace votess::fit {
namespace {

constexpr double first_change = 1;  // of log volume: root of the mean square, weighted by targets
constexpr double min_goal = 0.25;   // goal / volume: smaller cells die when larger ones move
constexpr double least_share = 1.0 / 1024, share_growth = 1.5;
constexpr double least_gain = 0.1;  // share of a step by which it comes nearer
// Steps change most cells from a larger residual, if log volume also differs by more: root of the mean square.
constexpr double long_step = 10, long_change = 0.8;
// A first step from a residual between these is followed by another one that changes most cells, and hardly a cell
// dies.
constexpr double short_residual = 1, dying_residual = 4;
// Cells that become smaller than `dying` of their volume and of their target are revived, unless they are too many.
constexpr double dying = 1e-4, max_dying = 0.1;
constexpr int max_revivals = 3, max_first_revivals = 40;
constexpr double left_small = 0.25, first_left_small = 1;  // share of small cells after a revival; else it ends
// In tight clusters the large cells move planes by more than the whole size of small ones, so steps of all cells are
// short. Then only the smallest cells grow until none is below a share of its target. The second share holds if steps
// are short again.
constexpr double short_share = 1.0 / 32, first_filling_share = 0.25, first_filled = 0.01, last_filled = 0.5;
// Tolerances of the linear solver: a share of the residual, within bounds. So convergence stays quadratic.
constexpr double solver_share = 0.001, least_solver_tolerance = 1e-7;

// A first step shorter than this, of so many seeds, is worth a fit of fewer seeds.
constexpr double hard_share = 0.2;
constexpr Eigen::Index min_seeds = 256;
constexpr double part_tolerance = 0.1;

constexpr double near = 0.01;  // a residual below which a larger tolerance may do

// Damping of steps upward, in means of the derivatives of volumes by weights.
constexpr double rounded = 1e-6;  // a residual below which rounding ends the approach
constexpr double first_damping = 0.1, max_damping = 1e6, damping_growth = 4;

// The lift at the start, if some cells have no mass then, or too many; the share of its target that a cell keeps when
// the lift sinks.
constexpr double some_lift = 1e-3, full_lift = 1, kept_mass = 0.3;
// The least lift of derivatives, times the residual: between bright places far apart the derivatives are 0, but mass
// has to move from cells of one to those of another.
constexpr double least_lift = 0.01;

// Infinite for an empty cell.
double distance_between(const Vector& volumes, const Vector& targets) {
    return (volumes.array() / targets.array()).log().matrix().norm();
}

}  // namespace

Newton::Newton(Problem problem, const FitOptions& options, VolumeFit& out)
    : problem_(std::move(problem)), options_(options), out_(out) {
    problem_.run.points = {problem_.points, {}};
    problem_.run.want = {};
    if (problem_.density && problem_.dimensions == 2) {
        problem_.run.want.volumes = false;
        problem_.run.list_walls = true;
    } else {
        problem_.run.want.areas = true;
        (problem_.density ? problem_.run.want.faces : problem_.run.want.centroids) = true;
    }
    problem_.run.precision = Precision::double_;
}

Weighted Newton::tessellate(Vector weights, Runner& runner) {
    const Timed timed(out_.seconds.tessellate);
    Weighted result;
    problem_.run.weights.given.assign(weights.begin(), weights.end());
    // Convergence is the progress of a fit; 0.95 to 1 is for the tessellation that is returned.
    const double digits = first_residual_ > 0 ? std::log(first_residual_ / now_.residual) : 0;
    const double all_digits = std::log(std::max(first_residual_, 2 * options_.tolerance) / options_.tolerance);
    const double done = problem_.is_part ? 0 : 0.95 * std::clamp(digits / all_digits, 0.0, 1.0);
    problem_.run.progress = Stoppable::within({done, done});
    result.tessellation = runner(problem_.run);
    result.weights = std::move(weights);
    if (const auto& density = problem_.density) {
        if (problem_.dimensions == 2)
            result.flat.emplace(
                result.tessellation, density->frame,
                fields::FlatSeeds{problem_.places, problem_.run.weights.given, problem_.run.region.walls},
                *problem_.pool);
        result.masses = fields::masses_in(result.tessellation, density->frame, density->values, *problem_.pool, false,
                                          result.flat ? &*result.flat : nullptr);
    }
    measure(result);
    ++out_.tessellations;
    return result;
}

// A runner stores cells for the next step, or for revivals, where these change few. One that cannot repair the cells of
// its last call stores few, while a new one stores all.
Weighted Newton::tessellate(Vector weights) {
    const bool is_first = now_.volumes.size() == 0;
    const bool is_far = is_first ? (weights.array() == 0).all()
                                 : out_.steps == 0 && now_.residual >= short_residual && now_.residual < dying_residual;
    problem_.run.follow = !is_far;
    Weighted result = tessellate(std::move(weights), runner_);
    if (!is_far && has_cells_ && result.tessellation.stats().kept_cells == 0)
        forget();
    else
        has_cells_ = !is_far;
    return result;
}

void Newton::forget() {
    runner_ = Runner();
    has_cells_ = false;
}

void Newton::measure(Weighted& of) const {
    const auto as_vector = [](std::span<const double> numbers) {
        return Eigen::Map<const Vector>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
    };
    of.volumes = as_vector(of.even_volumes());
    if (problem_.density) of.volumes = (1 - lift_) * as_vector(of.masses.masses) + lift_ * of.volumes;
    of.residual = errors(of).maxCoeff();
}

Vector Newton::errors(const Weighted& of) const {
    return ((of.volumes - problem_.targets).array() / problem_.targets.array()).abs();
}

void Newton::sink() {
    if (lift_ == 0) return;
    double least = 0;
    for (Eigen::Index i = 0; i < problem_.targets.size(); ++i) {
        const auto cell = static_cast<std::size_t>(i);
        const double kept = std::min(kept_mass * problem_.targets[i], now_.volumes[i]);
        const double mass = now_.masses.masses[cell];
        if (mass >= kept) continue;
        const double even = now_.even_volumes()[cell];
        least = std::max(least, (kept - mass) / (even - mass));
    }
    lift_ = std::min(lift_, least);
    measure(now_);
}

// The areas of faces, or their masses.
std::vector<double> Newton::areas() const {
    const std::span<const double> given = now_.face_areas();
    std::vector<double> areas(given.begin(), given.end());
    if (!problem_.density) return areas;
    const double lift = std::max(lift_, least_lift * std::min(1.0, now_.residual));
    for (std::size_t i = 0; i < areas.size(); ++i) areas[i] = (1 - lift) * now_.masses.face_masses[i] + lift * areas[i];
    return areas;
}

Weighted Newton::trial(const Vector& step) {
    const double change = distance_between(now_.volumes, problem_.targets);
    if (now_.residual > long_step && change > long_change * std::sqrt(static_cast<double>(step.size()))) forget();
    const Vector least = dying * now_.volumes.cwiseMin(problem_.targets);
    return revived(tessellate(now_.weights + step), now_.tessellation, least, max_revivals, left_small, max_dying);
}

Weighted Newton::revived(Weighted next, const Tessellation& before, const Vector& least, int attempts, double left,
                         double most) {
    Eigen::Index max_small = static_cast<Eigen::Index>(most * static_cast<double>(least.size()));
    for (int attempt = 0; attempt < attempts; ++attempt) {
        const Eigen::Index small = (next.volumes.array() < least.array()).count();
        if (small == 0 || small > max_small) break;
        max_small = static_cast<Eigen::Index>(left * static_cast<double>(small));
        Vector weights = std::move(next.weights);
        const double mean = weights.mean();
        const std::span<const double> centroids =
            problem_.density ? next.masses.centroids : next.tessellation.centroids();
        revive({problem_.places, problem_.edges, problem_.targets, before, next.tessellation, next.volumes, centroids,
                least, problem_.dimensions},
               attempt, weights);
        weights.array() += mean - weights.mean();
        next = tessellate(std::move(weights));
    }
    return next;
}

double Newton::smallest() const {
    return (now_.volumes.array() / problem_.targets.array()).minCoeff();
}

void Newton::choose_share() {
    const auto targets = problem_.targets.array();
    const double square = (targets * (now_.volumes.array() / targets).log().square()).sum() / targets.sum();
    share_ = std::min(1.0, first_change / std::sqrt(square));
}

void Newton::start_from_fewer() {
    choose_share();
    if (problem_.density || share_ >= hard_share || problem_.targets.size() < min_seeds) return;
    FitOptions options = options_;
    options.tolerance = std::max(part_tolerance, options_.tolerance);
    VolumeFit part_out;
    Newton part(fewer_seeds(problem_), options, part_out);
    (void)part.run(part.problem_.start);
    out_.tessellations += part_out.tessellations;
    out_.seconds.tessellate += part_out.seconds.tessellate;
    out_.seconds.assemble += part_out.seconds.assemble;
    out_.seconds.solve += part_out.seconds.solve;
    const Weighted& few = part.now();
    if (!(few.volumes.minCoeff() > 0)) return;
    Vector weights = spread(problem_, few);
    forget();
    weights.array() += now_.weights.mean() - weights.mean();
    Weighted next = revived(tessellate(std::move(weights)), now_.tessellation, dying * problem_.targets,
                            max_first_revivals, first_left_small, 1);
    if (distance_between(next.volumes, problem_.targets) < distance_between(now_.volumes, problem_.targets))
        now_ = std::move(next);
}

void Newton::fill() {
    filling_ = true;
    filled_ = filled_ == 0 ? first_filled : last_filled;
    share_ = first_filling_share;
}

Vector Newton::goal() const {
    const auto volumes = now_.volumes.array(), targets = problem_.targets.array();
    if (filling_) return volumes.max(std::pow(smallest(), 1 - share_) * targets);
    return volumes * (share_ * (targets / volumes).log()).max(std::log(min_goal)).exp();
}

// The roots are scaled so that the changes of volumes sum to 0.
Vector Newton::step_to(const Vector& goal) {
    const Timed timed(out_.seconds.solve);
    const auto volumes = now_.volumes.array();
    const double dimensions = problem_.dimensions;
    const Eigen::ArrayXd roots = (goal.array() / volumes).pow(1 / dimensions);
    const double scale = volumes.sum() / (volumes * roots).sum();
    Vector change = dimensions * volumes * (scale * roots - 1);
    change.array() -= change.mean();
    const double far = (change.array() / problem_.targets.array()).abs().maxCoeff();
    return solve(matrix_, change, std::clamp(solver_share * far, least_solver_tolerance, solver_share));
}

bool Newton::advance() {
    {
        const Timed timed(out_.seconds.assemble);
        set_laplacian(now_.tessellation, areas(), problem_.places, problem_.edges, matrix_);
    }
    if (damping_ > 0 && now_.residual <= climbed_ && now_.volumes.minCoeff() > 0) {
        damping_ = 0;
        choose_share();
    }
    if (damping_ > 0) return climb();
    if (approach()) return true;
    if (lift_ > 0 || now_.residual < rounded) return false;
    filling_ = false;
    climbed_ = 0.5 * std::min(now_.residual, 1.0);
    damping_ = first_damping * damping_unit();
    return climb();
}

bool Newton::approach() {
    const double before = distance_between(now_.volumes, problem_.targets);
    for (; share_ >= least_share; share_ /= 2) {
        if (!filling_ && share_ < short_share && smallest() < last_filled) fill();
        const Vector step = step_to(goal());
        if (!step.allFinite()) continue;
        Weighted next = trial(step);
        const double gain = filling_ ? 0 : least_gain * share_;
        if (!(distance_between(next.volumes, problem_.targets) <= (1 - gain) * before)) continue;
        now_ = std::move(next);
        share_ = std::min(share_growth * share_, 1.0);
        if (filling_ && smallest() >= filled_) {
            filling_ = false;
            choose_share();
        }
        return true;
    }
    return false;
}

void Newton::keep_best() {
    if (now_.volumes.minCoeff() > 0 && (!best_ || now_.residual < best_->residual)) best_ = now_;
}

double Newton::damping_unit() const {
    const auto places = Eigen::Map<const Eigen::Matrix3Xd>(problem_.places.data(), 3, problem_.targets.size());
    const double extent = (places.rowwise().maxCoeff() - places.rowwise().minCoeff()).squaredNorm();
    return std::max(matrix_.diagonal().mean(), problem_.targets.mean() / extent);
}

bool Newton::climb() {
    keep_best();
    const Vector rest = problem_.targets - now_.volumes;
    const double most = max_damping * damping_unit();
    for (; damping_ <= most; damping_ *= damping_growth) {
        Matrix damped = matrix_;
        damped.diagonal().array() += damping_;
        Vector step;
        {
            const Timed timed(out_.seconds.solve);
            step = solve(damped, rest, solver_share);
        }
        if (!step.allFinite()) continue;
        Weighted next = tessellate(now_.weights + step);
        const Vector left = problem_.targets - next.volumes;
        if (!(left.dot(step) >= 0 || left.norm() < rest.norm())) continue;  // beyond the top of this line
        now_ = std::move(next);
        damping_ /= damping_growth;
        return true;
    }
    return false;
}

bool Newton::run(Vector weights) {
    now_ = tessellate(std::move(weights));
    if (!(now_.volumes.minCoeff() > 0)) {
        Runner other;  // runner_ keeps the cells of now_
        Weighted even = tessellate(problem_.start, other);
        if (problem_.density) {
            now_ = revived(std::move(now_), even.tessellation, dying * problem_.targets, max_first_revivals,
                           first_left_small, max_dying);
            const auto empty = static_cast<double>((now_.volumes.array() <= 0).count());
            if (empty > 0) lift_ = empty > max_dying * static_cast<double>(now_.volumes.size()) ? full_lift : some_lift;
            measure(now_);
            measure(even);
        }
        if (!(now_.volumes.minCoeff() > 0)) now_ = std::move(even);
    }
    Eigen::Index smallest_cell = 0;
    if (!(now_.volumes.minCoeff(&smallest_cell) > 0)) {  // in a mesh, or outside of a periodic domain
        if (problem_.is_part) return false;
        std::array<double, 3> place;
        for (std::size_t k = 0; k < 3; ++k) place[k] = problem_.points[3 * at(smallest_cell) + k] / problem_.scale;
        refuse("point " + std::to_string(problem_.given[at(smallest_cell)]) + ": " +
               in_parentheses(std::span(place).first(at(problem_.dimensions))) + " has no cell, move it into the " +
               (problem_.run.region.mesh ? "mesh" : "domain"));
    }
    sink();
    start_from_fewer();
    choose_share();
    first_residual_ = now_.residual;
    constexpr unsigned idle = 50;
    double least = now_.residual;
    unsigned least_at = out_.steps;
    for (; !(now_.residual <= options_.tolerance) || lift_ > 0; ++out_.steps) {
        if (now_.residual < 0.999 * least) least = now_.residual, least_at = out_.steps;
        if (out_.steps == options_.max_steps)
            why_ = out_.steps - least_at < idle
                       ? "raise FitOptions::max_steps"
                       : "the last " + std::to_string(out_.steps - least_at) + " steps came no nearer";
        else if (!(now_.residual <= options_.tolerance) && !advance())
            why_ = now_.residual < near ? "no step comes nearer, raise FitOptions::tolerance" : "no step comes nearer";
        if (!why_.empty()) break;
        sink();
    }
    lift_ = 0;
    measure(now_);
    if (!why_.empty() && best_) {
        keep_best();
        now_ = std::move(*best_);
    }
    return why_.empty();
}

}  // namespace votess::fit

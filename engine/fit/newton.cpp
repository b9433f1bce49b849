#include "fit/newton.hpp"

#include <algorithm>
#include <cmath>

#include "core/progress.hpp"
#include "fit/timed.hpp"

namespace votess::fit {
namespace {

constexpr double first_factor = 4, least_factor = 1.5, largest_factor = 1e6;
// While the smallest share of a target is below this, only the smallest cells grow, at the cost of those that are too
// large. Larger cells move planes by more than the whole size of small ones. The second holds after a failed step.
constexpr double first_filling = 0.01, last_filling = 0.5;
constexpr double least_share = 1.0 / 1024;  // of a step
// Tolerances of the linear solver: a share of the residual, within bounds. So convergence stays quadratic.
constexpr double solver_share = 0.01, least_solver_tolerance = 1e-6;

}  // namespace

Newton::Newton(Problem problem, const FitOptions& options, VolumeFit& out)
    : problem_(std::move(problem)), options_(options), out_(out), factor_(first_factor), filling_(first_filling) {
    problem_.options.want = {};
    problem_.options.want.areas = true;
    problem_.options.precision = Precision::double_;
}

Weighted Newton::tessellate(Vector weights) {
    const Timed timed(out_.seconds.tessellate);
    Weighted result;
    problem_.options.weights = {weights.data(), static_cast<std::size_t>(weights.size())};
    // Convergence is the progress of a fit; 0.95 to 1 is for the tessellation that is returned.
    const double digits = first_residual_ > 0 ? std::log(first_residual_ / now_.residual) : 0;
    const double all_digits = std::log(std::max(first_residual_, 2 * options_.tolerance) / options_.tolerance);
    const double done = 0.95 * std::clamp(digits / all_digits, 0.0, 1.0);
    problem_.options.progress = Stoppable::within({done, done});
    result.tessellation = tessellator_.tessellate(problem_.points, problem_.options);
    const std::span<const double> volumes = result.tessellation.volumes();
    result.volumes = Eigen::Map<const Vector>(volumes.data(), static_cast<Eigen::Index>(volumes.size()));
    result.weights = std::move(weights);
    result.residual = ((result.volumes - problem_.targets).array() / problem_.targets.array()).abs().maxCoeff();
    ++out_.tessellations;
    return result;
}

// The goal sums to the volume of the domain, by a factor of the targets that bisection finds.
Vector Newton::goal() const {
    const auto volumes = now_.volumes.array(), targets = problem_.targets.array();
    if (((targets <= factor_ * volumes) && (targets * factor_ >= volumes)).all()) return problem_.targets;
    Vector goal;
    const double least = (volumes / targets).minCoeff();
    if (factor_ * least < filling_) {
        const Vector excess = (volumes - targets).max(0);
        goal = volumes.max(factor_ * least * targets);
        return goal - (goal.sum() - now_.volumes.sum()) / excess.sum() * excess;
    }
    double low = 1 / factor_, high = factor_;
    for (int i = 0; i < 50; ++i) {
        check_stop();
        const double scale = std::sqrt(low * high);
        goal = (scale * targets).min(factor_ * volumes).max(volumes / factor_);
        (goal.sum() > problem_.targets.sum() ? high : low) = scale;
    }
    return goal;
}

Vector Newton::direction(const Vector& goal) {
    {
        const Timed timed(out_.seconds.assemble);
        set_laplacian(now_.tessellation, problem_.places, problem_.edges, matrix_);
    }
    const Timed timed(out_.seconds.solve);
    Vector right = goal - now_.volumes;
    right -= right.sum() / goal.sum() * goal;
    const double far = (right.array() / goal.array()).abs().maxCoeff();
    return solve(matrix_, right, std::clamp(solver_share * far, least_solver_tolerance, solver_share));
}

double Newton::advance(const Vector& step, const Vector& goal) {
    if (!step.allFinite()) return 0;
    const double least = 0.5 * std::min(now_.volumes.minCoeff(), problem_.targets.minCoeff());
    const auto distance_of = [&](const Vector& volumes) {
        return ((volumes - goal).array() / goal.array()).matrix().norm();
    };
    const double distance = distance_of(now_.volumes);
    for (double share = 1; share >= least_share; share /= 2) {
        Weighted next = tessellate(now_.weights + share * step);
        if (next.volumes.minCoeff() < least || !(distance_of(next.volumes) <= (1 - share / 2) * distance)) continue;
        now_ = std::move(next);
        return share;
    }
    return 0;
}

bool Newton::run(Vector weights) {
    now_ = tessellate(std::move(weights));
    if (!(now_.volumes.minCoeff() > 0)) now_ = tessellate(Vector::Zero(now_.weights.size()));
    first_residual_ = now_.residual;
    for (; now_.residual > options_.tolerance; ++out_.steps) {
        if (out_.steps == options_.max_steps) {
            why_ = "raise max_steps";
            return false;
        }
        const Vector goal = this->goal();
        const double share = advance(direction(goal), goal);
        if (share == 1)
            factor_ = std::min(4 * factor_, largest_factor);
        else
            factor_ = std::max(factor_ / (share > 0 ? 2 : 16), least_factor);
        if (share == 0 && filling_ < last_filling && goal != problem_.targets) {
            filling_ = last_filling;
        } else if (share == 0 && (factor_ == least_factor || goal == problem_.targets)) {
            why_ = "no step comes nearer, raise tolerance";
            return false;
        }
    }
    return true;
}

}  // namespace votess::fit

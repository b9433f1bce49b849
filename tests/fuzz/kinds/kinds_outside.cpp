// Seeds beyond the walls of their domain, which are kept.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "fuzz/kinds/kinds.hpp"

namespace test::fuzz {
namespace {

// Returns a wall across an axis: at a seed, or halfway between two seeds, so that it may be their bisector, or a hair
// off. `otherwise` if all numbers are too far apart.
double wall_near_seeds(const Job& job, std::size_t axis, double otherwise, Random& random) {
    if (job.size() == 0) return otherwise;
    const double a = job.points[3 * random.below(job.size()) + axis],
                 b = job.points[3 * random.below(job.size()) + axis];
    const double at = random.chance(0.3) ? a : 0.5 * a + 0.5 * b;
    return std::isfinite(at) ? beside(at, random, 0.2) : otherwise;
}

// Moves the walls of a box inward, between the seeds.
void shrink_box(Job& job, Random& random) {
    for (std::size_t k = 0; k < 3; ++k) {
        if (job.periodic[k]) continue;
        double lower = wall_near_seeds(job, k, job.box->lower[k], random),
               upper = wall_near_seeds(job, k, job.box->upper[k], random);
        if (random.chance(0.3)) lower = job.box->lower[k];
        if (random.chance(0.3)) upper = job.box->upper[k];
        if (lower > upper) std::swap(lower, upper);
        if (!(lower < upper)) continue;
        job.box->lower[k] = lower;
        job.box->upper[k] = upper;
    }
}

}  // namespace

std::vector<Job> kept_outside(Random& random) {
    using Maker = std::vector<Job> (*)(Random&);
    constexpr Maker makers[] = {ties,          wrapped_pairs, tight_clusters, any_weights,  any_weights, smooth_weights,
                                walls_through, lattices,      on_spheres,     skewed_cells, thin_cells};
    std::vector<Job> jobs = makers[random.below(std::size(makers))](random);
    for (Job& job : jobs) {
        job.keep = true;
        job.drop = job.closed = false;
        job.may_refuse = true;  // skewed cells
        if (job.cell && job.cell->periodic == std::array{true, true, true} && random.chance(0.7)) {
            for (bool& axis : job.cell->periodic) axis = random.chance(0.5);
            // Seeds leave the cell along its edges.
            for (std::size_t i = 0; i < job.size(); ++i) {
                const double out = random.chance(0.5) ? random.uniform(-2, 2) : 0;
                const auto& edge = random.chance(0.5) ? job.cell->a : job.cell->c;
                for (std::size_t k = 0; k < 3; ++k) job.points[3 * i + k] += out * edge[k];
            }
        }
        if (job.box) shrink_box(job, random);
        if (!job.weights.empty() && random.chance(0.5)) {  // which bring cells of seeds outside into the domain
            const double least = random.chance(0.5) ? 0.5 : 1;
            const double curvature = random.chance(0.5) ? 1 : random.uniform(0.5, 1);
            for (std::size_t i = 0; i < job.size(); ++i) {
                double square = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    const double from = job.points[3 * i + k] - job.points[k];
                    square += from * from;
                }
                job.weights[i] += curvature * random.uniform(least, 1) * square;
            }
        }
        if (random.chance(0.3))
            for (double& x : job.weights) x = beside(x, random, 0.5);
    }
    return jobs;
}

}  // namespace test::fuzz

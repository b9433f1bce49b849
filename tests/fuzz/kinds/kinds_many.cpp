// Jobs one after the other, and many seeds.
#include <algorithm>
#include <cmath>

#include "fuzz/kinds/kinds.hpp"

namespace test::fuzz {
namespace {

// n seeds of one of several densities in a box, periodic or not.
Job crowd(std::size_t n, Random& random) {
    Job job;
    const double far = random.chance(0.7) ? 0 : decades(random, 0, 4);
    Vector lower{far, far, far}, sides{1, 1, 1};
    if (random.chance(0.3))
        for (double& side : sides) side = decades(random, -1, 1);
    take_box(job, lower, sides, random, false);
    const auto density = random.below(4);
    const double spread = decades(random, -9, -1);
    const int steps = 1 + static_cast<int>(std::cbrt(static_cast<double>(n)));
    const double nudge = random.chance(0.5) ? 0 : 0.01;
    Vector center{};
    for (std::size_t i = 0; i < n; ++i) {
        if (i % 200 == 0)
            for (double& f : center) f = random.chance(0.3) ? static_cast<double>(random.below(2)) : random.uniform();
        Vector x;
        for (std::size_t k = 0; k < 3; ++k) {
            double f = random.uniform();
            if (density == 1) f = center[k] + spread * random.uniform(-1, 1);
            if (density == 2) f = static_cast<double>(random.below(static_cast<std::uint64_t>(steps))) / steps;
            x[k] = lower[k] + f * sides[k];
            if (density == 2) x[k] = beside(x[k], random, nudge);
            // Copies of others, a box vector away and rounded.
            if (density == 3 && i > 0 && job.periodic[k] && i % 3 == 0)
                x[k] = job.points[3 * (i - 1) + k] +
                       static_cast<double>(random.integer(-1, 1)) * (job.box->upper[k] - job.box->lower[k]);
            if (density == 3 && i > 0 && !job.periodic[k] && i % 3 == 0) x[k] = job.points[3 * (i - 1) + k];
            if (!job.periodic[k]) x[k] = std::clamp(x[k], job.box->lower[k], job.box->upper[k]);
        }
        add_seed(job, x);
    }
    shuffle(job, random);
    if (random.chance(0.4)) {
        const double spacing = (density == 1 ? spread : 1) * std::min({sides[0], sides[1], sides[2]}) / steps;
        const double unit = spacing * spacing * decades(random, -12, random.chance(0.2) ? 4 : 0);
        // A common weight changes no cell, and hides the others' digits.
        const double common = random.chance(0.3) ? unit * decades(random, 0, 6) : 0;
        for (std::size_t i = 0; i < n; ++i) job.weights.push_back(common + unit * random.uniform());
    }
    return job;
}

}  // namespace

std::vector<Job> changing_jobs(Random& random) {
    std::vector<Job> jobs;
    for (auto count = 3 + random.below(4); count > 0; --count) {
        const auto how = random.below(8);
        Job job;
        if (how == 0 && !jobs.empty()) {  // the seeds move
            job = jobs.back();
            const double by = decades(random, -9, -2);
            for (std::size_t c = 0; c < job.points.size(); ++c) {
                job.points[c] += by * random.uniform(-1, 1);
                if (job.box) job.points[c] = std::clamp(job.points[c], job.box->lower[c % 3], job.box->upper[c % 3]);
            }
            job.drop = true;
        } else if (how == 1) {
            job = any_weights(random)[0];
        } else if (how == 2) {
            job = walls_through(random)[0];
        } else if (how == 3) {
            job = wrapped_pairs(random)[0];
        } else if (how == 4) {
            job = lattices(random)[0];
        } else if (how == 5) {
            job = tight_clusters(random)[0];
        } else {
            job =
                crowd(random.chance(0.1) ? random.below(2) : 1 + random.below(random.chance(0.8) ? 60 : 1500), random);
        }
        if (random.chance(0.2) && job.size() > 0 && job.box) {  // some seeds are outside
            job.drop = true;
            for (auto outside = 1 + random.below(3); outside > 0; --outside) {
                const auto c = random.below(job.points.size());
                if (!job.periodic[c % 3]) job.points[c] = job.box->upper[c % 3] + 1 + std::abs(job.box->upper[c % 3]);
            }
        }
        if (random.chance(0.2) && job.size() > 1 && job.size() < 60) {  // one that buries the others around it
            job.weights.resize(job.size());
            job.weights[random.below(job.size())] += decades(random, -3, 1);
        }
        if (random.chance(0.5)) job.want = static_cast<unsigned>(random.below(want_all + 1));
        job.list_walls = random.chance(0.5);
        constexpr unsigned grids[] = {0, 0, 1, 2, 7};
        job.grid_resolution = grids[random.below(std::size(grids))];
        job.threads = 1 + static_cast<unsigned>(random.below(3) / 2);
        job.may_refuse = true;
        job.follow = jobs.size() % 2 == 0;
        jobs.push_back(std::move(job));
    }
    return jobs;
}

std::vector<Job> many_seeds(Random& random) {
    Job job = crowd(static_cast<std::size_t>(decades(random, 3, random.chance(0.2) ? 4 : 3.4)), random);
    job.threads = 1 + static_cast<unsigned>(random.below(2));
    job.may_refuse = !job.weights.empty();
    return {job};
}

}  // namespace test::fuzz

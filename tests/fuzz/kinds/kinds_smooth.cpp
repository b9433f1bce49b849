// Kinds for searches that look beyond the seeds nearby: weights that move cells away from their seeds, and long cells.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fuzz/kinds/kinds.hpp"

namespace test::fuzz {
namespace {

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace

std::vector<Job> smooth_weights(Random& random) {
    Job job;
    const double size = random.chance(0.7) ? 1 : decades(random, -3, 3);
    const double far = random.chance(0.7) ? 0 : size * decades(random, 0, 5);
    const std::size_t n = 2 + random.below(random.chance(0.3) ? 10 : random.chance(0.5) ? 40 : 300);
    if (random.chance(0.2)) {
        votess::TriclinicBox cell{{far, far, far}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
        cell.b[0] = size * random.uniform(-0.6, 0.6), cell.c[0] = size * random.uniform(-0.6, 0.6);
        cell.c[1] = size * random.uniform(-0.6, 0.6);
        job.cell = cell;
        job.drop = job.list_walls = true;  // rounding may put seeds outside
    } else {
        take_box(job, {far, far, far}, {size, size, size}, random, false);
        if (random.chance(0.3)) job.periodic = {};
    }
    const bool grid = random.chance(0.2);
    for (std::size_t i = 0; i < n; ++i) {
        Vector f, x{far, far, far};
        for (double& value : f) value = grid ? static_cast<double>(random.below(6)) / 6 : random.uniform();
        for (std::size_t k = 0; k < 3; ++k)
            x[k] += job.cell ? f[0] * job.cell->a[k] + f[1] * job.cell->b[k] + f[2] * job.cell->c[k] : f[k] * size;
        add_seed(job, x);
    }
    // Waves and a slope whose cells lie up to some spacings beside their seeds.
    const double spacing = size / std::cbrt(static_cast<double>(n)), displaced = spacing * decades(random, -2, 0.8);
    const auto waves = random.below(4);
    const double slope = waves == 0 || random.chance(0.3) ? 1 : 0,
                 noise = random.chance(0.3) ? decades(random, -12, 0) : 0;
    std::vector<Vector> wave;
    std::vector<double> phase;
    for (std::size_t w = 0; w < waves; ++w) {
        wave.emplace_back();
        for (double& value : wave.back()) value = static_cast<double>(random.integer(-2, 2));
        phase.push_back(random.uniform(0, 2 * std::numbers::pi));
    }
    Vector along;
    for (double& value : along) value = random.uniform(-1, 1);
    const double heavy = random.chance(0.2) ? spacing * spacing * decades(random, -1, 3) : 0;
    for (std::size_t i = 0; i < n; ++i) {
        Vector x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = (job.points[3 * i + k] - far) / size;
        double weight = 2 * slope * dot(x, along);
        for (std::size_t w = 0; w < waves; ++w)
            weight += std::sin(2 * std::numbers::pi * dot(x, wave[w]) + phase[w]) / std::numbers::pi;
        weight = weight * displaced * size + noise * spacing * spacing * random.uniform();
        if (heavy > 0 && random.chance(0.02)) weight += heavy;
        job.weights.push_back(weight);
    }
    shuffle(job, random);
    return {job};
}

std::vector<Job> sheets(Random& random) {
    Job job;
    const double height = decades(random, -2, 1.5), rough = random.chance(0.4) ? 0 : decades(random, -12, -1);
    const std::size_t n = 3 + random.below(random.chance(0.5) ? 20 : 200), flat = random.chance(0.8) ? 1 : 2;
    Vector lower{}, sides{1, 1, 1};
    for (std::size_t k = 3 - flat; k < 3; ++k) sides[k] = height;
    take_box(job, lower, sides, random, false);
    const auto planes = 1 + random.below(2);
    const bool grid = random.chance(0.3);
    for (std::size_t i = 0; i < n; ++i) {
        Vector x;
        for (std::size_t k = 0; k < 3; ++k) {
            x[k] = sides[k] * (grid ? static_cast<double>(random.below(8)) / 8 : random.uniform());
            if (k >= 3 - flat)
                x[k] = 0.5 * sides[k] + 0.2 * static_cast<double>(random.below(planes)) + rough * random.uniform(-1, 1);
            x[k] = std::clamp(x[k], 0.0, sides[k]);
        }
        add_seed(job, x);
    }
    if (random.chance(0.2))
        for (std::size_t i = 0; i < n; ++i) job.weights.push_back(0.1 * random.uniform() / static_cast<double>(n));
    return {job};
}

}  // namespace test::fuzz

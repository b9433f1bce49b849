// Few seeds in shapes full of ties and near-ties, at any scale.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "fuzz/kinds/kinds.hpp"

namespace test::fuzz {
namespace {

constexpr int shapes = 18, tiny_shape = shapes;

// One seed of a shape. size and jitter are the set's: steps of its grid, and the deviation from exact ties.
Vector draw(int shape, int size, double jitter, Random& random) {
    const auto grid = [&] { return static_cast<double>(random.integer(0, size)); };
    const auto any = [&] { return random.uniform(); };
    const auto off = [&] { return jitter * random.uniform(-1, 1); };
    const auto mixed = [&](const int(&values)[3]) {  // any axes and signs
        const auto turn = random.below(3);
        Vector x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = (random.chance(0.5) ? 1 : -1) * values[(k + turn) % 3];
        return x;
    };
    switch (shape) {
        case 0:
            return {grid(), grid(), grid()};
        case 1:
            return {any(), any(), any()};
        case 2: {  // body-centered
            const double half = random.chance(0.3) ? 0.5 : 0;
            return {grid() + half, grid() + half, grid() + half};
        }
        case 3:
            return {1e8 + grid() * 0x1p-20, 1e8 + grid() * 0x1p-20, -1e8 + grid() * 0x1p-20};
        case 4:
            return {1e8 + 1e-3 * any(), 1e8 + 1e-3 * any(), 1e8 + 1e-3 * any()};
        case 5:
            return {grid() * 1e-10, grid() * 1e-10, grid() * 1e-10};
        case 6:
            return {beside(1 + grid(), random, 0.4), beside(1 + grid(), random, 0.4), beside(1 + grid(), random, 0.4)};
        case 7: {  // on the faces of a cube
            Vector x{random.uniform(0, size), random.uniform(0, size), random.uniform(0, size)};
            for (double& c : x)
                if (random.chance(0.5)) c = random.chance(0.5) ? 0 : size;
            return x;
        }
        case 8: {  // a plane through integer points, or a line in it
            const double u = grid(), v = random.chance(0.3) ? 0 : grid();
            return {2 * u + 3 * v, -u, -v};
        }
        case 9: {  // integer points of a sphere, exactly or nearly
            static constexpr int sphere[4][3] = {{3, 0, 0}, {2, 2, 1}, {1, 2, 2}, {2, 1, 2}};
            Vector x = mixed(sphere[random.below(4)]);
            for (double& c : x) c = beside(c, random, size % 2 == 0 ? 0.4 : 0);
            return x;
        }
        case 10: {  // a larger sphere, and its points of a plane and a line
            static constexpr int sphere[4][3] = {{9, 0, 0}, {8, 4, 1}, {7, 4, 4}, {6, 6, 3}};
            const Vector x = mixed(sphere[random.below(4)]);
            if (size == 5) return {x[0], 2 * x[0], -3 * x[0]};
            return size == 4 ? Vector{x[0], x[1], -x[0] - x[1]} : x;
        }
        case 11: {  // clusters in clusters
            const double scale = std::ldexp(1.0, -static_cast<int>(random.below(40)));
            const double center = size % 2 == 0 ? 0 : 0.3;
            return {center + scale * any(), center + scale * any(), center + scale * any()};
        }
        case 12:
            return {grid() * 0.1, grid() * 0.1, grid() * 0.1};
        case 13: {  // few different coordinates close together: slabs and needles
            const double step = std::ldexp(1.0, -static_cast<int>(10 * random.below(6)));
            return {0.25 + (random.chance(0.5) ? step * 0.25 : 0), 0.5 + grid() * step * 0.01, 0.75};
        }
        case 14:
            return {grid() + off(), grid() + off(), grid() + off()};
        case 15:
            return {any(), any() * jitter, grid()};
        case 16: {  // nearly on a plane
            const double u = any(), v = any();
            return {u, v, 0.25 + 0.25 * u + 0.5 * v + off()};
        }
        case 17: {  // nearly on a sphere
            Vector x{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            const double length = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) + 1e-3;
            for (double& c : x) c = c / length * (1 + off());
            return x;
        }
        default:
            return {grid() * 0x1p-300, grid() * 0x1p-300, grid() * 0x1p-300};
    }
}

// A box that touches the seeds or has room around them. The default box where the seeds have no volume.
void box_around(Job& job, Random& random) {
    const double room = random.chance(0.5) ? 0 : std::ldexp(random.uniform(), static_cast<int>(random.below(20)));
    votess::Box box;
    for (std::size_t k = 0; k < 3; ++k) {
        box.lower[k] = box.upper[k] = job.points[k];
        for (std::size_t c = k; c < job.points.size(); c += 3) {
            box.lower[k] = std::min(box.lower[k], job.points[c]);
            box.upper[k] = std::max(box.upper[k], job.points[c]);
        }
        const double width = box.upper[k] - box.lower[k];
        box.lower[k] -= room * width;
        box.upper[k] += room * width;
        if (!(box.lower[k] < box.upper[k])) return;
    }
    job.box = box;
}

// Weights that bury no seed, some or most of them.
void add_weights(Job& job, int steps, Random& random) {
    double size = 0;
    for (const double x : job.points) size = std::max(size, std::abs(x - job.points[0]));
    const double square = std::pow(size / std::cbrt(static_cast<double>(job.size())), 2);
    const double factor = std::ldexp(square, static_cast<int>(random.integer(-12, 6)));
    const double offset = random.chance(0.3) ? std::ldexp(square, static_cast<int>(random.integer(0, 50))) : 0;
    const auto how = random.below(5);
    for (std::size_t i = 0; i < job.size(); ++i) {
        double w = random.uniform();
        if (how == 1) w *= w;
        if (how == 2) w = std::round(w);
        if (how == 3 && random.chance(0.1)) w = random.chance(0.8) ? 100 : -1e6;
        const double tie = size * size * static_cast<double>(random.below(4)) / (steps * steps);
        job.weights.push_back(how == 4 ? tie : offset + factor * w);
    }
    if (random.chance(0.2)) job.weights[random.below(job.size())] *= std::ldexp(1, static_cast<int>(random.below(12)));
}

Job few_seeds(bool extreme, Random& random) {
    constexpr double jitters[] = {0, 0, 1e-17, 1e-15, 1e-12, 1e-7, 1e-4, 1e-2, 0.3};
    const int shape = extreme && random.chance(0.5) ? tiny_shape : static_cast<int>(random.below(shapes));
    const int other = random.chance(extreme ? 0.5 : 0.15) ? static_cast<int>(random.below(3)) : shape;
    const int size = static_cast<int>(random.integer(1, 5));
    const double jitter = jitters[random.below(std::size(jitters))];
    const double near = random.chance(0.1) ? random.uniform(0, 0.5) : 0.1;  // the share of near-duplicates
    // The oracle's time grows with the cube of the number.
    const auto n = random.chance(0.7)              ? 2 + random.below(9)
                   : extreme || random.chance(0.9) ? 11 + random.below(14)
                                                   : 25 + random.below(76);
    Job job;
    while (job.size() < n) {
        Vector x = draw(random.chance(0.8) ? shape : other, size, jitter, random);
        if (job.size() > 0 && random.chance(near)) {
            const std::size_t j = random.below(job.size());
            for (std::size_t k = 0; k < 3; ++k) {
                x[k] = job.points[3 * j + k];
                // The neighbors of 0 are far beyond the scales of the rest.
                if (random.chance(0.4) && (extreme || x[k] != 0))
                    x[k] = std::nextafter(x[k], random.chance(0.5) ? HUGE_VAL : -HUGE_VAL);
            }
        }
        add_seed(job, x);
    }
    if (!extreme && random.chance(0.2)) {  // the sums lose digits, which makes ties
        const double far = std::ldexp(random.uniform(-1, 1), static_cast<int>(random.below(50)));
        for (double& x : job.points) x += far;
    }
    if (!extreme && random.chance(0.3)) {
        const int power = static_cast<int>(random.integer(-230, 230));
        for (double& x : job.points) x = std::ldexp(x, power);
    }
    if (random.chance(0.65)) box_around(job, random);
    if (!extreme && random.chance(0.3)) add_weights(job, size, random);
    job.may_refuse = extreme || !job.weights.empty();
    constexpr unsigned grids[] = {0, 0, 1, 2, 5, 50};
    job.grid_resolution = grids[random.below(std::size(grids))];
    job.threads = 1 + static_cast<unsigned>(random.below(3) / 2);
    job.list_walls = random.chance(0.7);
    return job;
}

}  // namespace

std::vector<Job> ties(Random& random) {
    return {few_seeds(false, random)};
}

std::vector<Job> extremes(Random& random) {
    return {few_seeds(true, random)};
}

}  // namespace test::fuzz

#include "support/scattered.hpp"

#include "support/check.hpp"
#include "support/random.hpp"

namespace test {

void scatter(int kind, std::size_t count, double far, bool weighted, std::uint64_t rng_seed, Scattered& out) {
    Random random(rng_seed);
    out.points.clear();
    out.weights.clear();
    out.options = all_options(unit_box());
    out.options.outside = votess::Outside::keep;
    if (kind == 1) out.options.periodic = {true, false, false};
    if (kind == 2) out.options.periodic = {true, false, true};
    if (kind == 3) out.options.walls = votess::sphere_walls({0.5, 0.5, 0.5}, 0.45, 40);
    if (kind == 4 || kind == 5) {
        out.options.box.reset();
        out.options.cell = {{0.125, 0.25, 0}, {1, 0.25, 0}, {-0.5, 1.25, 0.25}, {0.125, -0.5, 0.75}, {}};
        if (kind == 5) out.options.cell->periodic = {false, true, false};
    }
    for (std::size_t i = 0; i < 3 * count; ++i) {
        const double beyond = i / 3 % 2 == 0 ? far : 0;
        out.points.push_back(random.uniform(-beyond, 1 + beyond));
    }
    for (std::size_t i = 0; i < count && weighted; ++i) {
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double from = out.points[3 * i + k] - 0.5;
            square += from * from;
        }
        out.weights.push_back(square * random.uniform(0.8, 1) + random.uniform(0, 0.02));
    }
    out.options.weights = out.weights;
}

}  // namespace test

// Kinds of periodic domains.
#include <algorithm>
#include <cmath>

#include "fuzz/kinds/kinds.hpp"

namespace test::fuzz {
namespace {

Vector edge(const Job& job, std::size_t j) {
    if (job.cell) return j == 0 ? job.cell->a : j == 1 ? job.cell->b : job.cell->c;
    Vector v{};
    if (job.periodic[j]) v[j] = job.box->upper[j] - job.box->lower[j];
    return v;
}

double volume(const votess::TriclinicBox& cell) {
    const auto &a = cell.a, &b = cell.b, &c = cell.c;
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// At fractions of the box or cell; rounding may put it a hair outside along an axis that does not repeat.
Vector at(const Job& job, const Vector& fraction) {
    Vector x{};
    if (job.cell) {
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = job.cell->origin[k] + fraction[0] * job.cell->a[k] + fraction[1] * job.cell->b[k] +
                   fraction[2] * job.cell->c[k];
        return x;
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const double lower = job.box->lower[k], upper = job.box->upper[k];
        x[k] = std::clamp(lower + fraction[k] * (upper - lower), lower, upper);
    }
    return x;
}

double fraction(Random& random) {
    const auto how = random.below(6);
    if (how == 0) return 0;
    if (how == 1) return static_cast<double>(random.below(4)) / 4;
    if (how == 2) return decades(random, -17, -3);
    return random.uniform();
}

// Then rounding may put seeds outside.
void end_some_edges(Job& job, Random& random) {
    if (!random.chance(0.3)) return;
    for (bool& repeats : job.cell->periodic) repeats = random.chance(0.5);
    job.drop = job.list_walls = true;
}

void some_weights(Job& job, double largest, Random& random) {
    if (!random.chance(0.25)) return;
    for (std::size_t i = 0; i < job.size(); ++i) job.weights.push_back(largest * random.uniform());
}

}  // namespace

std::vector<Job> wrapped_pairs(Random& random) {
    Job job;
    const double far = random.chance(0.3) ? decades(random, 0, 8) : 1;
    Vector lower, sides;
    const bool round = random.chance(0.3);
    for (std::size_t k = 0; k < 3; ++k) {
        lower[k] = round ? static_cast<double>(random.integer(-2, 1)) : far * random.uniform(-1, 1);
        sides[k] = round ? static_cast<double>(1 + random.below(3)) / 3 : random.uniform(0.3, 3);
    }
    if (random.chance(0.3)) {
        votess::TriclinicBox cell{lower, {sides[0], 0, 0}, {0, sides[1], 0}, {0, 0, sides[2]}};
        for (double* x : {&cell.b[0], &cell.c[0], &cell.c[1]})
            *x = round ? static_cast<double>(random.integer(-2, 2)) / 6 : random.uniform(-0.5, 0.5);
        if (random.chance(0.3)) {
            votess::TriclinicBox full = cell;
            for (double* x : {&full.a[1], &full.a[2], &full.b[2]}) *x = random.uniform(-0.3, 0.3);
            // Flat cells are refused, and have a kind of their own.
            if (std::abs(volume(full)) > 0.05 * sides[0] * sides[1] * sides[2]) cell = full;
        }
        job.cell = cell;
        end_some_edges(job, random);
    } else {
        take_box(job, lower, sides, random, true);
    }
    const double nudge = random.chance(0.5) ? 0 : 0.3;
    for (auto bases = 1 + random.below(3); bases > 0; --bases) {
        const Vector base = at(job, {fraction(random), fraction(random), fraction(random)});
        add_seed(job, base);
        for (auto copies = 1 + random.below(3); copies > 0; --copies) {
            Vector x = base;
            for (std::size_t j = 0; j < 3; ++j) {
                const double times = static_cast<double>(random.integer(-2, 2) / (random.chance(0.5) ? 2 : 1));
                const Vector v = edge(job, j);
                for (std::size_t k = 0; k < 3; ++k) x[k] += times * v[k];
            }
            for (std::size_t k = 0; k < 3; ++k)
                if (job.cell || job.periodic[k]) x[k] = beside(x[k], random, nudge);
            add_seed(job, x);
        }
    }
    for (auto others = random.below(4); others > 0; --others)
        add_seed(job, at(job, {random.uniform(), random.uniform(), random.uniform()}));
    shuffle(job, random);
    some_weights(job, 0.1, random);
    return {job};
}

std::vector<Job> thin_cells(Random& random) {
    Job job;
    Vector sides, lower{};
    for (double& side : sides) side = random.chance(0.3) ? 1 : decades(random, -5, 5);
    if (random.chance(0.3))
        for (double& x : lower) x = random.uniform(-1, 1) * decades(random, -3, 3);
    for (std::size_t k = 0; k < 3; ++k)  // or no box at all
        if (!(lower[k] + sides[k] > lower[k])) lower[k] = 0;
    take_box(job, lower, sides, random, true);
    job.may_refuse = true;
    for (auto n = 1 + random.below(6); n > 0; --n)
        add_seed(job, at(job, {fraction(random), fraction(random), fraction(random)}));
    some_weights(job, std::pow(std::min({sides[0], sides[1], sides[2]}), 2), random);
    return {job};
}

std::vector<Job> skewed_cells(Random& random) {
    Job job;
    votess::TriclinicBox cell{};
    const bool thin = random.chance(0.5);
    Vector sides;
    for (double& side : sides) side = thin ? decades(random, -3, 3) : random.uniform(0.5, 2);
    cell.a[0] = sides[0];
    cell.b[1] = sides[1];
    cell.c[2] = sides[2];
    const auto skew = [&](double along) {
        const double most = random.chance(0.5) ? 1 : decades(random, 0, 5);
        return (random.chance(0.4) ? std::round(random.uniform(-1, 1) * most) : random.uniform(-1, 1) * most) * along;
    };
    cell.b[0] = skew(sides[0]);
    cell.c[0] = skew(sides[0]);
    cell.c[1] = skew(sides[1]);
    if (random.chance(0.2)) std::swap(cell.a, cell.c);
    if (random.chance(0.3))
        for (double& x : cell.origin) x = random.uniform(-3, 3);
    job.cell = cell;
    end_some_edges(job, random);
    job.may_refuse = true;
    for (auto n = 1 + random.below(6); n > 0; --n)
        add_seed(job, at(job, {fraction(random), fraction(random), fraction(random)}));
    some_weights(job, std::pow(std::min({sides[0], sides[1], sides[2]}), 2), random);
    return {job};
}

std::vector<Job> tight_clusters(Random& random) {
    Job job;
    const double far = random.chance(0.5) ? 0 : decades(random, 0, 6),
                 size = random.chance(0.7) ? 1 : decades(random, -2, 2);
    Vector lower, sides;
    for (std::size_t k = 0; k < 3; ++k) {
        lower[k] = far * (random.chance(0.5) ? 1 : random.uniform(-1, 1));
        sides[k] = size * (random.chance(0.5) ? 1 : random.uniform(0.5, 2));
    }
    take_box(job, lower, sides, random, false);
    const double spacing = std::max(far, size) * decades(random, -13, -2);
    // In a plane or a line the cells of a cluster are long.
    const auto dimensions = 1 + random.below(3);
    for (auto clusters = 1 + random.below(3); clusters > 0; --clusters) {
        Vector center{};
        for (double& f : center) f = random.chance(0.5) ? static_cast<double>(random.below(2)) : fraction(random);
        center = at(job, center);
        for (auto n = 2 + random.below(5); n > 0; --n) {
            Vector x = center;
            for (std::size_t k = 0; k < dimensions; ++k) x[k] += spacing * random.uniform(-1, 1);
            for (std::size_t k = 0; k < 3; ++k)
                if (!job.periodic[k]) x[k] = std::clamp(x[k], job.box->lower[k], job.box->upper[k]);
            add_seed(job, x);
        }
    }
    shuffle(job, random);
    if (random.chance(0.25)) {
        const double weight = spacing * spacing * decades(random, -6, 1);
        for (std::size_t i = 0; i < job.size(); ++i) job.weights.push_back(weight * random.uniform());
    }
    return {job};
}

}  // namespace test::fuzz

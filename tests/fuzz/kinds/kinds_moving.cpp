// Seeds that move from call to call, a little or far, all or some, and what else may change between calls.
#include <algorithm>
#include <cmath>

#include "fuzz/kinds/kinds.hpp"

namespace test::fuzz {
namespace {

using Base = std::vector<Job> (*)(Random& random);

Job uniform_seeds(Random& random, std::size_t count) {
    Job job;
    Vector sides{1, 1, 1}, lower{};
    for (std::size_t k = 0; k < 3; ++k) {
        if (random.chance(0.2)) sides[k] = decades(random, -1, 1);
        if (random.chance(0.2)) lower[k] = random.uniform(-5, 5);
    }
    take_box(job, lower, sides, random, false);
    for (std::size_t i = 0; i < count; ++i) {
        Vector x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = lower[k] + sides[k] * random.uniform();
        add_seed(job, x);
    }
    return job;
}

Job lattice(Random& random, std::size_t side) {
    Job job;
    take_box(job, {}, {1, 1, 1}, random, false);
    for (std::uint64_t i = 0; i < side * side * side; ++i) {
        Vector x;
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = (static_cast<double>(k == 0   ? i % side
                                        : k == 1 ? i / side % side
                                                 : i / side / side) +
                    0.5) /
                   static_cast<double>(side);
        add_seed(job, x);
    }
    return job;
}

Vector sides_of(const Job& job) {
    Vector sides{1, 1, 1};
    for (std::size_t k = 0; k < 3 && job.box; ++k) sides[k] = job.box->upper[k] - job.box->lower[k];
    return sides;
}

// Makes the box triclinic. By quarters, lattices keep their ties.
void tilt(Job& job, Random& random) {
    const Vector sides = sides_of(job);
    const auto part = [&] { return random.chance(0.5) ? random.uniform(-0.6, 0.6) : 0.25 * random.integer(-2, 2); };
    votess::TriclinicBox cell;
    cell.origin = job.box->lower;
    cell.a[0] = sides[0];
    cell.b = {part() * sides[0], sides[1], 0};
    cell.c = {part() * sides[0], part() * sides[1], sides[2]};
    job.box.reset();
    job.periodic = {};
    job.cell = cell;
}

double beyond(const votess::Wall& wall, const double* x) {
    return wall.normal[0] * x[0] + wall.normal[1] * x[1] + wall.normal[2] * x[2] - wall.offset;
}

// Adds walls, of which some meet seeds or corners of the box. The middle of the box is inside.
void add_walls(Job& job, Random& random) {
    const Vector sides = sides_of(job), lower = job.box->lower;
    Vector middle;
    for (std::size_t k = 0; k < 3; ++k) middle[k] = lower[k] + 0.5 * sides[k];
    for (auto walls = 1 + random.below(random.chance(0.1) ? 40 : 5); walls > 0; --walls) {
        votess::Wall wall;
        const bool simple = random.chance(0.5);
        for (double& n : wall.normal) n = simple ? static_cast<double>(random.integer(-1, 1)) : random.uniform(-1, 1);
        if (wall.normal == std::array<double, 3>{}) wall.normal[0] = 1;
        Vector at;
        const bool by_seed = random.chance(0.3), by_corner = random.chance(0.3);
        const auto i = random.below(job.size());
        for (std::size_t k = 0; k < 3; ++k) {
            at[k] = lower[k] + sides[k] * (by_corner ? static_cast<double>(random.below(2)) : random.uniform());
            if (by_seed) at[k] = job.points[3 * i + k];
        }
        wall.offset = 0;
        wall.offset = beyond(wall, at.data());
        if (beyond(wall, middle.data()) >= 0) {
            for (double& n : wall.normal) n = -n;
            wall.offset = -wall.offset;
        }
        if (beyond(wall, middle.data()) < 0) job.walls.push_back(wall);
    }
}

// Removes seeds beyond walls, or puts them back to where they were.
void stay_inside(Job& job, const Job& before) {
    for (std::size_t i = job.size(); i-- > 0;) {
        const auto is_outside = [&](const Job& of) {
            return std::ranges::any_of(job.walls,
                                       [&](const auto& wall) { return beyond(wall, &of.points[3 * i]) > 0; });
        };
        if (!is_outside(job)) continue;
        if (before.size() == job.size() && !is_outside(before))
            std::copy_n(&before.points[3 * i], 3, &job.points[3 * i]);
        else if (job.size() > 1)
            job = job.without(i, i + 1);
    }
}

// Moves seeds, and changes what a call may change.
void change(Job& job, const Job& first, Random& random) {
    const Job before = job;
    const Vector sides = sides_of(job);
    const std::size_t count = job.size();
    const double spacing = std::cbrt(sides[0] * sides[1] * sides[2] / static_cast<double>(count));
    const double by = random.chance(0.15) ? 0 : spacing * decades(random, -8, random.chance(0.2) ? 0 : -1.5);
    const auto seed = [&] { return random.below(count); };
    const auto how = random.below(24);
    if (how == 0) {  // one goes anywhere
        const auto i = seed();
        for (std::size_t k = 0; k < 3 && job.box; ++k)
            job.points[3 * i + k] = job.box->lower[k] + sides[k] * random.uniform();
    } else if (how == 1) {  // a duplicate
        const auto i = seed(), j = seed();
        std::copy_n(&job.points[3 * j], 3, &job.points[3 * i]);
        if (!job.weights.empty() && random.chance(0.5)) job.weights[i] = job.weights[j];
    } else if (how == 2 && count > 2) {
        job = job.without(seed(), count);
    } else if (how == 3) {  // all in one direction
        Vector way;
        for (double& x : way) x = by * random.uniform(-1, 1);
        for (std::size_t c = 0; c < 3 * count; ++c) job.points[c] += way[c % 3];
    } else if (how == 4 && !job.walls.empty()) {  // onto a wall or near it, some exactly
        const auto i = seed();
        const votess::Wall& wall = job.walls[random.below(job.walls.size())];
        const auto k = static_cast<std::size_t>(
            std::ranges::max_element(wall.normal, {}, [](double n) { return std::abs(n); }) - wall.normal.begin());
        job.points[3 * i + k] -= beyond(wall, &job.points[3 * i]) / wall.normal[k];
        if (random.chance(0.5)) job.points[3 * i + k] -= std::copysign(by, wall.normal[k]);
    } else if (how == 4 && job.box) {  // onto a wall
        const auto i = seed(), k = random.below(3);
        job.points[3 * i + k] = random.chance(0.5) ? job.box->lower[k] : job.box->upper[k];
    } else if (how == 5 && job.box) {  // images
        for (std::size_t c = 0; c < 3 * count; ++c)
            if (job.periodic[c % 3] && random.chance(0.1))
                job.points[c] += sides[c % 3] * static_cast<double>(random.integer(-1, 1));
    } else if (how == 6) {  // two change places
        const auto i = seed(), j = seed();
        for (std::size_t k = 0; k < 3; ++k) std::swap(job.points[3 * i + k], job.points[3 * j + k]);
    } else if (how == 7) {  // back
        job.points = first.points;
        job.weights = first.weights;
    } else if (how == 8) {  // a part of them
        for (std::size_t i = 0; i < count; ++i)
            if (random.chance(0.1))
                for (std::size_t k = 0; k < 3; ++k) job.points[3 * i + k] += by * random.uniform(-1, 1);
    } else if (how == 9 && !job.walls.empty()) {  // another domain, of as many walls or fewer
        if (random.chance(0.5))
            job.walls.pop_back();
        else
            job.walls[random.below(job.walls.size())].offset += by;
    } else if (how == 9 && job.box) {  // the domain grows
        const double factor = 1 + decades(random, -8, -1);
        for (std::size_t k = 0; k < 3; ++k) {
            job.box->upper[k] = job.box->lower[k] + sides[k] * factor;
            for (std::size_t i = 0; i < count; ++i) {
                double& x = job.points[3 * i + k];
                x = job.box->lower[k] + (x - job.box->lower[k]) * factor;
            }
        }
    } else if (how == 10 && !job.weights.empty()) {  // one becomes hidden, or returns
        job.weights[seed()] += spacing * spacing * random.uniform(-5, 5);
    } else if (how == 11 && job.box) {  // ties
        for (std::size_t c = 0; c < 3 * count; ++c)
            if (random.chance(0.05)) {
                const double at = std::floor(8 * (job.points[c] - job.box->lower[c % 3]) / sides[c % 3]) / 8;
                job.points[c] = job.box->lower[c % 3] + at * sides[c % 3];
            }
    } else if (how == 12) {  // some leave
        for (auto leave = 1 + random.below(3); leave > 0 && job.size() > 1; --leave) {
            const auto i = random.below(job.size());
            job = job.without(i, i + 1);
        }
    } else if (how == 13) {  // some come
        for (auto come = 1 + random.below(3); come > 0; --come) {
            const auto like = random.below(job.size()),
                       row = random.chance(0.5) ? job.size() : random.below(job.size());
            Vector x;
            for (std::size_t k = 0; k < 3; ++k) x[k] = job.points[3 * like + k] + spacing * random.uniform(-1, 1);
            job.points.insert(job.points.begin() + static_cast<std::ptrdiff_t>(3 * row), x.begin(), x.end());
            if (!job.weights.empty())
                job.weights.insert(job.weights.begin() + static_cast<std::ptrdiff_t>(row), job.weights[like]);
        }
    } else if (how == 14) {  // rows change places
        const auto row = seed();
        if (random.chance(0.5))
            std::rotate(job.points.begin(), job.points.begin() + static_cast<std::ptrdiff_t>(3 * row),
                        job.points.end());
        else
            for (std::size_t i = 0; i < row; ++i) {
                const auto j = seed();
                std::swap_ranges(&job.points[3 * i], &job.points[3 * i] + 3, &job.points[3 * j]);
            }
    } else {
        for (double& x : job.points) x += by * random.uniform(-1, 1);
        if (random.chance(0.3))
            for (double& w : job.weights) w += by * spacing * random.uniform(-1, 1);
    }
    for (std::size_t c = 0; c < job.points.size() && job.box; ++c)
        if (!job.periodic[c % 3] && !job.drop)
            job.points[c] = std::clamp(job.points[c], job.box->lower[c % 3], job.box->upper[c % 3]);
    if (!job.walls.empty() && !job.drop) stay_inside(job, before);
}

void add_weights(Job& job, Random& random) {
    const Vector sides = sides_of(job);
    const double square = std::pow(sides[0] * sides[1] * sides[2] / static_cast<double>(job.size()), 2.0 / 3);
    const double unit = square * decades(random, -3, random.chance(0.2) ? 1 : -0.5);
    for (std::size_t i = 0; i < job.size(); ++i) job.weights.push_back(unit * random.uniform());
}

// Puts walls into some boxes.
void enclose(Job& job, Random& random) {
    if (!job.box || !job.walls.empty() || !random.chance(0.3)) return;
    job.periodic = {};
    add_walls(job, random);
    job.drop = random.chance(0.3);
    if (!job.drop) stay_inside(job, job);
}

// Returns the job and what becomes of it.
std::vector<Job> history(Job job, std::uint64_t steps, Random& random) {
    const Job first = job;
    std::vector<Job> jobs;
    for (; steps > 0; --steps) {
        job.follow = !random.chance(0.03);
        // Polygons are made afresh.
        constexpr unsigned no_polygons = 0xff;
        job.want = static_cast<unsigned>(random.below(no_polygons + 1)) | (random.chance(0.5) ? 3u : 0u);
        if (random.chance(0.03)) job.want = want_all;
        job.list_walls = random.chance(0.3);
        job.threads = 1 + static_cast<unsigned>(random.below(8) / 7);
        job.may_refuse = true;
        jobs.push_back(job);
        if (job.size() > 0) change(job, first, random);
    }
    return jobs;
}

}  // namespace

std::vector<Job> moving_seeds(Random& random) {
    constexpr Base others[] = {ties,           wrapped_pairs, thin_cells,    tight_clusters, any_weights,
                               smooth_weights, lattices,      walls_through, skewed_cells};
    Job job;
    const auto kind = random.below(10);
    if (kind < 6)
        job = uniform_seeds(random, 20 + random.below(random.chance(0.8) ? 200 : 1000));
    else if (kind < 8)
        job = lattice(random, 2 + random.below(6));
    else
        job = others[random.below(std::size(others))](random)[0];
    if (kind < 6 && random.chance(0.3)) add_weights(job, random);
    if (kind < 8 && job.box && random.chance(0.25)) tilt(job, random);
    enclose(job, random);
    return history(job, 3 + random.below(8), random);
}

std::vector<Job> long_histories(Random& random) {
    const bool on_lattice = random.chance(0.25);
    Job job = on_lattice ? lattice(random, 2 + random.below(2)) : uniform_seeds(random, 5 + random.below(56));
    if (random.chance(0.3)) add_weights(job, random);
    if (random.chance(0.2)) tilt(job, random);
    enclose(job, random);
    return history(job, 50, random);
}

}  // namespace test::fuzz

// Kinds with near-ties: weights, walls, lattices, spheres.
#include <algorithm>
#include <cmath>

#include "fuzz/kinds/kinds.hpp"

namespace test::fuzz {
namespace {

double square(const Vector& a, const Vector& b) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return sum;
}

Vector seed_of(const Job& job, std::size_t i) {
    return {job.points[3 * i], job.points[3 * i + 1], job.points[3 * i + 2]};
}

Vector any_vector(Random& random, bool simple) {
    Vector v{};
    while (v == Vector{})
        for (double& x : v) x = simple ? static_cast<double>(random.integer(-2, 2)) : random.uniform(-1, 1);
    return v;
}

// Coordinates in a cube: any, or those of a coarse grid.
Vector any_place(Random& random, double size, bool grid) {
    Vector x;
    for (double& value : x) value = size * (grid ? static_cast<double>(random.below(5)) / 4 : random.uniform());
    return x;
}

// Where three planes meet.
bool meet(const votess::Wall& a, const votess::Wall& b, const votess::Wall& c, Vector& x) {
    const auto cross = [](const Vector& u, const Vector& v) -> Vector {
        return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    };
    const Vector bc = cross(b.normal, c.normal), ca = cross(c.normal, a.normal), ab = cross(a.normal, b.normal);
    double d = 0;
    for (std::size_t k = 0; k < 3; ++k) d += a.normal[k] * bc[k];
    if (std::abs(d) < 1e-6) return false;
    for (std::size_t k = 0; k < 3; ++k) x[k] = (a.offset * bc[k] + b.offset * ca[k] + c.offset * ab[k]) / d;
    return true;
}

votess::Wall bisector(const Vector& a, const Vector& b) {
    votess::Wall plane{};
    for (std::size_t k = 0; k < 3; ++k) {
        plane.normal[k] = b[k] - a[k];
        plane.offset += (b[k] - a[k]) * (b[k] + a[k]) / 2;
    }
    return plane;
}

votess::Wall through(const Vector& x, const Vector& normal) {
    votess::Wall wall{normal, 0};
    for (std::size_t k = 0; k < 3; ++k) wall.offset += normal[k] * x[k];
    return wall;
}

}  // namespace

std::vector<Job> any_weights(Random& random) {
    Job job;
    const double size = random.chance(0.7) ? 1 : decades(random, -3, 3);
    const double far = random.chance(0.7) ? 0 : size * decades(random, 0, 5);
    const bool grid = random.chance(0.4);
    take_box(job, {far, far, far}, {size, size, size}, random, false);
    if (random.chance(0.4)) job.periodic = {};
    if (random.chance(0.1)) job.box.reset(), job.periodic = {};
    const std::size_t n = 2 + random.below(10);
    const double hair = random.chance(0.3) ? decades(random, -12, -2) : 0;
    for (std::size_t i = 0; i < n; ++i) {
        Vector x = any_place(random, size, grid);
        if (i > 0 && hair > 0 && random.chance(0.5)) {  // near another
            x = seed_of(job, random.below(i));
            for (double& value : x) value += size * hair * random.uniform(-1, 1) - far;
        }
        for (double& value : x) value = std::clamp(value + far, far, far + size);
        add_seed(job, x);
    }
    const double unit = size * size * decades(random, -30, 6);
    const auto pattern = random.below(5);
    const Vector tie = any_place(random, size, grid);
    for (std::size_t i = 0; i < n; ++i) {
        double w = unit * random.uniform(-1, 1);
        if (pattern == 0) w = random.chance(0.5) ? unit : 0;
        if (pattern == 1) w = unit * static_cast<double>(random.below(4));
        if (pattern >= 3) {  // the power distances to one place are equal but for rounding
            const Vector x = seed_of(job, i);
            w = beside(square(x, {tie[0] + far, tie[1] + far, tie[2] + far}), random, 0.5);
            if (pattern == 4) w += unit;  // most of the digits are lost
        }
        job.weights.push_back(w);
    }
    job.may_refuse = true;
    return {job};
}

std::vector<Job> walls_through(Random& random) {
    Job job;
    const bool grid = random.chance(0.6);
    const double far = random.chance(0.8) ? 0 : static_cast<double>(random.below(1000));
    if (random.chance(0.7)) job.box = votess::Box{{far, far, far}, {far + 1, far + 1, far + 1}};
    const std::size_t n = 2 + random.below(9);
    for (std::size_t i = 0; i < n; ++i) {
        Vector x = any_place(random, 1, grid);
        for (double& value : x) value = beside(value, random, 0.05);
        for (double& value : x) value = std::clamp(value + far, far, far + 1);
        add_seed(job, x);
    }
    for (auto walls = 1 + random.below(4); walls > 0; --walls) {
        const Vector normal = any_vector(random, grid);
        Vector x = seed_of(job, random.below(n));
        if (random.chance(0.4)) {  // through a vertex of the diagram, nearly
            const auto a = random.below(n), b = random.below(n), c = random.below(n), d = random.below(n);
            const Vector p = seed_of(job, a);
            (void)meet(bisector(p, seed_of(job, b)), bisector(p, seed_of(job, c)), bisector(p, seed_of(job, d)), x);
        } else if (random.chance(0.2)) {  // in the plane of a face
            const auto a = random.below(n), b = random.below(n);
            if (seed_of(job, a) != seed_of(job, b)) {
                job.walls.push_back(bisector(seed_of(job, a), seed_of(job, b)));
                continue;
            }
        }
        votess::Wall wall = through(x, normal);
        if (random.chance(0.2)) wall.offset = beside(wall.offset, random, 1);
        if (random.chance(0.2)) {
            const double factor = decades(random, -8, 8);
            for (double& value : wall.normal) value *= factor;
            wall.offset *= factor;
        }
        job.walls.push_back(wall);
    }
    // More than are tried in order: equal to others, multiples of them, to rounding, or turned a little.
    const std::size_t more = random.chance(0.1) ? 36 : 0;
    while (job.walls.size() < more) {
        votess::Wall wall = job.walls[random.below(job.walls.size())];
        const auto how = random.below(3);
        const double factor = how == 0 ? 1 : static_cast<double>(2 + random.below(2));
        for (double& value : wall.normal) value *= factor;
        wall.offset *= factor;
        if (how == 2) wall.normal[random.below(3)] += random.uniform(-0.1, 0.1);
        job.walls.push_back(wall);
    }
    if (random.chance(0.3))
        for (std::size_t i = 0; i < n; ++i) job.weights.push_back(random.uniform(-0.1, 0.2));
    job.drop = true;
    job.may_refuse = true;  // the walls may leave no room, or be too far away
    return {job};
}

std::vector<Job> wedges(Random& random) {
    Job job;
    const double e = decades(random, -12, 0);
    const Vector size{decades(random, -1, 2), decades(random, -1, 2), 1};
    // z from -e (1 + x) to e (1 + x), or a slab, up to x = size; turned when asked for by swapping axes.
    const bool slab = random.chance(0.3);
    const std::size_t turn = random.below(3);
    const auto add = [&](const Vector& n, double offset) {
        votess::Wall wall{{}, offset};
        for (std::size_t k = 0; k < 3; ++k) wall.normal[(k + turn) % 3] = n[k];
        job.walls.push_back(wall);
    };
    for (const double sign : {-1.0, 1.0}) add({slab ? 0 : -e, 0, sign}, e);
    add({1, 0, 0}, size[0]);
    if (slab) add({-1, 0, 0}, size[0]);
    for (const double sign : {-1.0, 1.0}) add({0, sign, 0}, size[1]);
    for (auto n = 1 + random.below(5); n > 0; --n) {
        const double x = size[0] * random.uniform(slab ? -1 : 0, 1);
        const Vector place{x, size[1] * random.uniform(-1, 1), 0.9 * e * random.uniform(-1, 1)};
        Vector turned;
        for (std::size_t k = 0; k < 3; ++k) turned[(k + turn) % 3] = place[k];
        add_seed(job, turned);
    }
    job.closed = true;
    return {job};
}

std::vector<Job> lattices(Random& random) {
    Job job;
    const int per_axis = 2 + static_cast<int>(random.below(2));
    const auto sort = random.below(4);
    const double step = random.chance(0.5) ? 1 : random.chance(0.5) ? 0.1 : decades(random, -8, 3);
    const double far = random.chance(0.7) ? 0 : step * static_cast<double>(random.below(100000));
    const double side = step * per_axis;
    const bool sheared = random.chance(0.3);
    if (sheared) {
        const double s = static_cast<double>(random.integer(-2, 2)) * step;
        job.cell = votess::TriclinicBox{{far, far, far}, {side, 0, 0}, {s, side, 0}, {0, -s, side}};
    } else {
        take_box(job, {far, far, far}, {side, side, side}, random, false);
    }
    const double probability = random.chance(0.4) ? 0 : random.chance(0.5) ? 0.02 : 0.4;
    const double offset = random.chance(0.5) ? 0 : 0.5;  // on the faces of the box, or not
    const auto add = [&](double a, double b, double c) {
        if (random.chance(0.03)) return;  // a hole
        Vector x{a, b, c};
        for (std::size_t k = 0; k < 3; ++k) {
            x[k] = beside(far + (x[k] + offset / 2) * step, random, probability);
            if (!sheared && !job.periodic[k]) x[k] = std::clamp(x[k], job.box->lower[k], job.box->upper[k]);
        }
        add_seed(job, x);
    };
    for (int a = 0; a < per_axis; ++a)
        for (int b = 0; b < per_axis; ++b)
            for (int c = 0; c < per_axis; ++c) {
                if (sort == 2) {  // face-centered of half the density
                    if ((a + b + c) % 2 == 0) add(a, b, c);
                    continue;
                }
                add(a, b, c);
                if (sort == 1) add(a + 0.5, b + 0.5, c + 0.5);
            }
    if (job.size() == 0) add_seed(job, {far, far, far});
    shuffle(job, random);
    if (random.chance(0.2))
        for (std::size_t i = 0; i < job.size(); ++i)
            job.weights.push_back(static_cast<double>(random.below(3)) * step * step / 8);
    job.list_walls = random.chance(0.5);
    return {job};
}

std::vector<Job> on_spheres(Random& random) {
    Job job;
    constexpr int squares[] = {3, 5, 6, 9, 14, 17};
    const int r2 = squares[random.below(std::size(squares))];
    const double step = random.chance(0.6) ? 1 : decades(random, -5, 5), far = random.chance(0.7) ? 0 : step * 1000;
    const double probability = random.chance(0.4) ? 0 : random.chance(0.5) ? 0.05 : 0.5;
    const double kept = random.uniform(0.3, 1);
    for (int a = -4; a <= 4; ++a)
        for (int b = -4; b <= 4; ++b)
            for (int c = -4; c <= 4; ++c) {
                if (a * a + b * b + c * c != r2 || !random.chance(kept) || job.size() >= 24) continue;
                Vector x{static_cast<double>(a), static_cast<double>(b), static_cast<double>(c)};
                for (double& value : x) value = beside(far + value * step, random, probability);
                add_seed(job, x);
            }
    if (random.chance(0.4) || job.size() == 0) add_seed(job, {far, far, far});
    if (random.chance(0.5)) {
        const double room = step * (random.chance(0.5) ? 5 : 9);
        take_box(job, {far - room, far - room, far - room}, {2 * room, 2 * room, 2 * room}, random, false);
    }
    shuffle(job, random);
    return {job};
}

}  // namespace test::fuzz

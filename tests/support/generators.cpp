#include "support/generators.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/random.hpp"

namespace test {

namespace {

using Vector = std::array<double, 3>;

void add(PointSet& set, double x, double y, double z) {
    set.points.insert(set.points.end(), {x, y, z});
}

double clamp_unit(double x) {
    return std::clamp(x, 0.0, 1.0);
}

// Box whose walls are `margin` outside the points.
votess::Box bounds(const Coordinates& points, double margin) {
    votess::Box box;
    for (std::size_t a = 0; a < 3; ++a) {
        box.lower[a] = box.upper[a] = points[a];
        for (std::size_t i = a; i < points.size(); i += 3) {
            box.lower[a] = std::min(box.lower[a], points[i]);
            box.upper[a] = std::max(box.upper[a], points[i]);
        }
        box.lower[a] -= margin;
        box.upper[a] += margin;
    }
    return box;
}

// Every point of basis * integers + motif inside the cube [0, length]³.
PointSet lattice(std::string name, const std::array<std::array<int, 3>, 3>& basis,
                 const std::vector<std::array<int, 3>>& motif, int length) {
    PointSet set{std::move(name), {}, cube(-0.5, length + 0.5)};
    const int reach = 2 * length + 2;
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            for (int k = -reach; k <= reach; ++k)
                for (const auto& m : motif) {
                    std::array<int, 3> p;
                    for (std::size_t a = 0; a < 3; ++a)
                        p[a] = i * basis[0][a] + j * basis[1][a] + k * basis[2][a] + m[a];
                    if (std::all_of(p.begin(), p.end(), [&](int x) { return x >= 0 && x <= length; }))
                        add(set, p[0], p[1], p[2]);
                }
    return set;
}

Vector on_unit_sphere(Random& random) {
    for (;;) {
        const Vector v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        const double r = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        if (r > 0.1 && r < 1) return {v[0] / r, v[1] / r, v[2] / r};
    }
}

int side_of(std::size_t n) {
    return std::max(2, static_cast<int>(std::lround(std::cbrt(static_cast<double>(n)))));
}

}  // namespace

votess::Box cube(double lower, double upper) {
    return {{lower, lower, lower}, {upper, upper, upper}};
}

std::vector<votess::Wall> octahedron(double size) {
    std::vector<votess::Wall> walls;
    for (const double x : {-1., 1.})
        for (const double y : {-1., 1.})
            for (const double z : {-1., 1.}) walls.push_back({{x, y, z}, size + 0.5 * (x + y + z)});
    return walls;
}

PointSet uniform(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"uniform", {}, unit_box()};
    for (std::size_t i = 0; i < 3 * n; ++i) set.points.push_back(random.uniform());
    return set;
}

PointSet clustered(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    std::array<Vector, 50> center;
    std::array<double, 50> sigma;
    for (std::size_t c = 0; c < 50; ++c) {
        center[c] = {random.uniform(), random.uniform(), random.uniform()};
        sigma[c] = random.uniform(0.01, 0.05);
    }
    PointSet set{"clustered", {}, unit_box()};
    while (set.size() < n) {
        const std::size_t c = random.below(50);
        Vector p;
        for (std::size_t a = 0; a < 3; ++a) p[a] = center[c][a] + sigma[c] * random.gaussian();
        if (std::all_of(p.begin(), p.end(), [](double x) { return x >= 0 && x <= 1; })) add(set, p[0], p[1], p[2]);
    }
    return set;
}

PointSet nested_clusters(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"nested clusters", {}, unit_box()};
    for (std::size_t i = 0; i < n; ++i) {
        double size = 0.5;
        for (std::uint64_t level = random.below(13); level > 0; --level) size /= 10;
        Vector p;
        for (auto& x : p) x = clamp_unit(0.375 + size * random.uniform(-0.5, 0.5));
        add(set, p[0], p[1], p[2]);
    }
    return set;
}

PointSet near_duplicates(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"near duplicates", {}, unit_box()};
    Vector p{};
    for (std::size_t i = 0; i < n; ++i) {
        if (i % 3 == 0) {
            p = {random.uniform(0.1, 0.9), random.uniform(0.1, 0.9), random.uniform(0.1, 0.9)};
        } else {
            auto& x = p[random.below(3)];
            x = std::nextafter(x, random.chance(0.5) ? 2.0 : -1.0);
        }
        add(set, p[0], p[1], p[2]);
    }
    return set;
}

PointSet far_from_origin(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"far from the origin", {}, std::nullopt};
    for (std::size_t i = 0; i < 3 * n; ++i) set.points.push_back(1e8 + 1e-3 * random.uniform());
    return set;
}

PointSet on_walls(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"on walls", {}, unit_box()};
    for (std::size_t i = 0; i < n; ++i) {
        Vector p{random.uniform(), random.uniform(), random.uniform()};
        for (auto& x : p)
            if (random.chance(0.5)) x = static_cast<double>(random.below(2));
        add(set, p[0], p[1], p[2]);
    }
    return set;
}

PointSet with_duplicates(std::size_t n, std::size_t copies, std::uint64_t seed) {
    PointSet set = uniform(n - copies, seed);
    set.name = "duplicates";
    Random random(seed + 1);
    const auto chosen = permutation(n - copies, random);
    for (std::size_t c = 0; c < copies; ++c) {
        const std::size_t i = chosen[c % chosen.size()];
        add(set, set.points[3 * i], set.points[3 * i + 1], set.points[3 * i + 2]);
    }
    return reordered(std::move(set), Order::shuffled, seed + 2);
}

PointSet cubic(std::size_t per_axis, double spacing) {
    const double last = static_cast<double>(per_axis) - 1;
    PointSet set{spacing == 1 ? "cubic" : "cubic, inexact spacing", {}, cube(-spacing / 2, (last + 0.5) * spacing)};
    for (std::size_t i = 0; i < per_axis; ++i)
        for (std::size_t j = 0; j < per_axis; ++j)
            for (std::size_t k = 0; k < per_axis; ++k)
                add(set, static_cast<double>(i) * spacing, static_cast<double>(j) * spacing,
                    static_cast<double>(k) * spacing);
    return set;
}

PointSet bcc(int length) {
    return lattice("bcc", {{{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}}, {{0, 0, 0}, {1, 1, 1}}, length);
}

PointSet fcc(int length) {
    return lattice("fcc", {{{1, 1, 0}, {1, 0, 1}, {0, 1, 1}}}, {{0, 0, 0}}, length);
}

// (1,-1,0) and (0,1,-1) span a triangular lattice: exact in integers, unlike the usual one with its square root of 3.
PointSet hexagonal(int length) {
    return lattice("hexagonal", {{{1, -1, 0}, {0, 1, -1}, {1, 1, 1}}}, {{0, 0, 0}}, length);
}

// Layers A and B of the fcc stacking along (1,1,1), times 3, and the third layer straight above the first.
PointSet close_packed(int length) {
    return lattice("close packed", {{{3, -3, 0}, {0, 3, -3}, {4, 4, 4}}}, {{0, 0, 0}, {3, 3, 0}}, length);
}

PointSet diamond(int length) {
    return lattice("diamond", {{{2, 2, 0}, {2, 0, 2}, {0, 2, 2}}}, {{0, 0, 0}, {1, 1, 1}}, length);
}

PointSet jittered(std::size_t per_axis, double amplitude, std::uint64_t seed) {
    Random random(seed);
    PointSet set = cubic(per_axis);
    set.name = "jittered cubic";
    for (auto& x : set.points) x += random.uniform(-amplitude, amplitude);
    return set;
}

PointSet on_axis_plane(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"on an axis-parallel plane", {}, unit_box()};
    for (std::size_t i = 0; i < n; ++i) {
        const double x = random.uniform();
        add(set, x, random.uniform(), 0.3);
    }
    return set;
}

PointSet on_oblique_plane(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"on an oblique plane", {}, std::nullopt};
    const int side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(n))));
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            // Half of them on a regular grid, the others at random places of the same plane, duplicates allowed.
            const auto u = random.chance(0.5) ? i : static_cast<int>(random.below(1000));
            const auto v = random.chance(0.5) ? j : static_cast<int>(random.below(1000));
            add(set, 2 * u + 3 * v, -u, -v);
        }
    return set;
}

PointSet on_axis_line(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"on an axis-parallel line", {}, unit_box()};
    for (std::size_t i = 0; i < n; ++i) add(set, 0.7, random.uniform(), 0.1);
    return set;
}

PointSet on_oblique_line(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"on an oblique line", {}, std::nullopt};
    for (std::size_t i = 0; i < n; ++i) {
        const auto t = static_cast<double>(random.below(100 * n));
        add(set, t, 2 * t, 3 * t);
    }
    return set;
}

PointSet on_sphere(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    PointSet set{"on a sphere", {}, cube(-1.5, 1.5)};
    for (std::size_t i = 0; i < n; ++i) {
        const Vector v = on_unit_sphere(random);
        add(set, v[0], v[1], v[2]);
    }
    return set;
}

PointSet on_sphere_and_center(std::size_t n, std::uint64_t seed) {
    PointSet set = on_sphere(n - 1, seed);
    set.name = "on a sphere, and its center";
    add(set, 0, 0, 0);
    return set;
}

PointSet cospherical(int squared_radius) {
    const int r = static_cast<int>(std::sqrt(squared_radius)) + 1;
    PointSet set{"cospherical", {}, cube(-2.0 * r, 2.0 * r)};
    for (int x = -r; x <= r; ++x)
        for (int y = -r; y <= r; ++y)
            for (int z = -r; z <= r; ++z)
                if (x * x + y * y + z * z == squared_radius) add(set, x, y, z);
    return set;
}

PointSet cospherical_and_center(int squared_radius) {
    PointSet set = cospherical(squared_radius);
    set.name = "cospherical, and the center";
    add(set, 0, 0, 0);
    return set;
}

PointSet cocircular(int squared_radius, int layers) {
    const int r = static_cast<int>(std::sqrt(squared_radius)) + 1;
    PointSet set{"cocircular", {}, std::nullopt};
    for (int z = 0; z < layers; ++z)
        for (int x = -r; x <= r; ++x)
            for (int y = -r; y <= r; ++y)
                if (x * x + y * y == squared_radius) add(set, x, y, z);
    set.box = bounds(set.points, 1);
    return set;
}

PointSet reordered(PointSet set, Order order, std::uint64_t seed) {
    const std::size_t n = set.size();
    std::vector<std::size_t> index(n);
    std::iota(index.begin(), index.end(), std::size_t{0});
    switch (order) {
        case Order::as_made:
            break;
        case Order::reversed:
            std::reverse(index.begin(), index.end());
            break;
        case Order::interleaved:  // first, last, second, last but one, ...
            for (std::size_t i = 0; i < n; ++i) index[i] = i % 2 == 0 ? i / 2 : n - 1 - i / 2;
            break;
        case Order::by_last_coordinate:
            std::stable_sort(index.begin(), index.end(), [&](std::size_t a, std::size_t b) {
                return set.points[3 * a + 2] < set.points[3 * b + 2];
            });
            break;
        case Order::shuffled: {
            Random random(seed);
            index = permutation(n, random);
            break;
        }
    }
    Coordinates points;
    points.reserve(3 * n);
    for (const std::size_t i : index)
        points.insert(points.end(), {set.points[3 * i], set.points[3 * i + 1], set.points[3 * i + 2]});
    set.points = std::move(points);
    return set;
}

PointSet scaled(PointSet set, double factor) {
    for (auto& x : set.points) x *= factor;
    if (set.box)
        for (std::size_t a = 0; a < 3; ++a) {
            set.box->lower[a] *= factor;
            set.box->upper[a] *= factor;
        }
    return set;
}

std::vector<PointSet> families(std::size_t n, std::uint64_t seed) {
    const int side = side_of(n);
    const auto per_axis = static_cast<std::size_t>(side);
    // Lattices with several or spread points per cube: choose the edge so that about n points fall inside.
    const auto edge = [&](double density) {
        return std::max(2, static_cast<int>(std::cbrt(static_cast<double>(n) / density)) - 1);
    };
    std::vector<PointSet> all{uniform(n, seed),
                              clustered(n, seed),
                              nested_clusters(n, seed),
                              near_duplicates(n, seed),
                              far_from_origin(n, seed),
                              on_walls(n, seed),
                              with_duplicates(n, std::max<std::size_t>(1, n / 10), seed),
                              cubic(per_axis),
                              cubic(per_axis, 0.1),
                              bcc(edge(0.25)),
                              fcc(edge(0.5)),
                              hexagonal(edge(1.0 / 3)),
                              close_packed(std::max(6, edge(1.0 / 54))),
                              diamond(edge(1.0 / 8)),
                              jittered(per_axis, 0.01, seed),
                              jittered(per_axis, 1e-15, seed),
                              on_axis_plane(n, seed),
                              on_oblique_plane(n, seed),
                              on_axis_line(n, seed),
                              on_oblique_line(n, seed),
                              on_sphere(n, seed),
                              on_sphere_and_center(n, seed),
                              cospherical(n < 100 ? 9 : 101),
                              cospherical_and_center(n < 100 ? 6 : 101),
                              cocircular(25, std::max(2, static_cast<int>(n / 12)))};
    for (const auto& [factor, label] :
         {std::pair{1e-10, " * 1e-10"}, std::pair{1e10, " * 1e10"}, std::pair{0x1p-40, " * 2^-40"},
          std::pair{0x1p40, " * 2^40"}, std::pair{0x1p-300, " * 2^-300"}, std::pair{0x1p300, " * 2^300"}}) {
        for (PointSet base : {uniform(n, seed), cubic(per_axis)}) {
            base = scaled(std::move(base), factor);
            base.name += label;
            all.push_back(std::move(base));
        }
    }
    return all;
}

}  // namespace test

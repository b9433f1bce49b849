#include "support/solids.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace test {
namespace {

using Vector = std::array<double, 3>;

Vector edge(const Solid& s, std::int32_t from, std::int32_t to) {
    Vector e;
    for (std::size_t k = 0; k < 3; ++k)
        e[k] = s.vertices[3 * static_cast<std::size_t>(to) + k] - s.vertices[3 * static_cast<std::size_t>(from) + k];
    return e;
}

Vector crossed(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

double Solid::volume() const {
    double sum = 0;
    const std::int32_t from = triangles[0];
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
        const Vector a = edge(*this, from, triangles[t]), b = edge(*this, from, triangles[t + 1]),
                     c = edge(*this, from, triangles[t + 2]), n = crossed(b, c);
        sum += a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
    }
    return sum / 6;
}

double Solid::area() const {
    double sum = 0;
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
        const Vector n =
            crossed(edge(*this, triangles[t], triangles[t + 1]), edge(*this, triangles[t], triangles[t + 2]));
        sum += std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }
    return sum / 2;
}

Solid Solid::reversed() const {
    Solid other = *this;
    for (std::size_t t = 0; t < triangles.size(); t += 3) std::swap(other.triangles[t + 1], other.triangles[t + 2]);
    return other;
}

Solid cuboid(const Vector& lower, const Vector& upper) {
    Solid s;
    for (const double x : {lower[0], upper[0]})
        for (const double y : {lower[1], upper[1]})
            for (const double z : {lower[2], upper[2]}) s.vertices.insert(s.vertices.end(), {x, y, z});
    s.triangles = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                   2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    return s;
}

Solid cuboid(double lower, double upper) {
    return cuboid(Vector{lower, lower, lower}, Vector{upper, upper, upper});
}

Solid tetrahedron(const std::array<Vector, 4>& corners) {
    Solid s;
    for (const Vector& x : corners) s.vertices.insert(s.vertices.end(), x.begin(), x.end());
    s.triangles = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    return s.volume() < 0 ? s.reversed() : s;
}

Solid torus(int around, int across) {
    Solid s;
    const auto index = [&](int a, int b) { return (a % around) * across + b % across; };
    for (int a = 0; a < around; ++a)
        for (int b = 0; b < across; ++b) {
            const double u = 2 * std::numbers::pi * a / around, v = 2 * std::numbers::pi * b / across;
            const double r = 1 + 0.4 * std::cos(v);
            s.vertices.insert(s.vertices.end(), {r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)});
            for (const int i :
                 {index(a, b), index(a + 1, b), index(a + 1, b + 1), index(a, b), index(a + 1, b + 1), index(a, b + 1)})
                s.triangles.push_back(i);
        }
    return s;
}

Solid spring(int turns, int steps, int across) {
    Solid s;
    const int rings = turns * steps + 1;
    for (int a = 0; a < rings; ++a)
        for (int b = 0; b < across; ++b) {
            const double u = 2 * std::numbers::pi * a / steps, v = 2 * std::numbers::pi * b / across;
            const double r = 1 + 0.2 * std::cos(v);
            s.vertices.insert(s.vertices.end(),
                              {r * std::cos(u), r * std::sin(u), static_cast<double>(a) / steps + 0.2 * std::sin(v)});
        }
    const auto index = [&](int a, int b) { return a * across + b % across; };
    for (int a = 0; a + 1 < rings; ++a)
        for (int b = 0; b < across; ++b)
            for (const int i :
                 {index(a, b), index(a + 1, b), index(a + 1, b + 1), index(a, b), index(a + 1, b + 1), index(a, b + 1)})
                s.triangles.push_back(i);
    for (int b = 2; b < across; ++b) {
        s.triangles.insert(s.triangles.end(), {index(0, 0), index(0, b - 1), index(0, b)});
        s.triangles.insert(s.triangles.end(), {index(rings - 1, 0), index(rings - 1, b), index(rings - 1, b - 1)});
    }
    return s;
}

Solid cubes(const std::array<int, 3>& count, const std::vector<bool>& filled) {
    Solid s;
    using Place = std::array<int, 3>;
    const auto is_filled = [&](const Place& x) {
        for (std::size_t k = 0; k < 3; ++k)
            if (x[k] < 0 || x[k] >= count[k]) return false;
        return static_cast<bool>(filled[static_cast<std::size_t>((x[0] * count[1] + x[1]) * count[2] + x[2])]);
    };
    const auto vertex = [&](const Place& x) { return (x[0] * (count[1] + 1) + x[1]) * (count[2] + 1) + x[2]; };
    Place x;
    for (x[0] = 0; x[0] <= count[0]; ++x[0])
        for (x[1] = 0; x[1] <= count[1]; ++x[1])
            for (x[2] = 0; x[2] <= count[2]; ++x[2]) s.vertices.insert(s.vertices.end(), x.begin(), x.end());
    for (x[0] = 0; x[0] < count[0]; ++x[0])
        for (x[1] = 0; x[1] < count[1]; ++x[1])
            for (x[2] = 0; x[2] < count[2]; ++x[2])
                for (std::size_t k = 0; k < 3 && is_filled(x); ++k)
                    for (const int side : {0, 1}) {
                        Place beside = x, a = x;
                        beside[k] += side == 1 ? 1 : -1;
                        if (is_filled(beside)) continue;
                        a[k] += side;
                        Place b = a, c = a, d = a;
                        ++b[(k + 1) % 3], ++c[(k + 1) % 3], ++c[(k + 2) % 3], ++d[(k + 2) % 3];
                        if (side == 0) std::swap(b, d);
                        for (const Place& corner : {a, b, c, a, c, d}) s.triangles.push_back(vertex(corner));
                    }
    return s;
}

Solid joined(const Solid& a, const Solid& b) {
    Solid s = a;
    s.vertices.insert(s.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const std::int32_t v : b.triangles)
        s.triangles.push_back(v + static_cast<std::int32_t>(a.vertices.size() / 3));
    return s;
}

NearBisector near_bisector(NearBisector::Kind kind, Random& random) {
    using Kind = NearBisector::Kind;
    const auto decimal = [&](std::int64_t lower, std::int64_t upper) {  // in tenths
        return static_cast<double>(random.integer(lower, upper)) / 10;
    };
    const auto moved = [](double x, double by) { return std::round(10 * (x + by)) / 10; };
    NearBisector set;
    if (random.chance(0.5)) {
        Vector lower, upper;
        for (std::size_t k = 0; k < 3; ++k) lower[k] = decimal(-8, 3), upper[k] = moved(lower[k], decimal(1, 6));
        set.solid = cuboid(lower, upper);
    } else {
        do {
            std::array<Vector, 4> corners;
            for (Vector& x : corners)
                for (double& coordinate : x) coordinate = decimal(-9, 9);
            set.solid = tetrahedron(corners);
        } while (!(set.solid.volume() > 0.02));
    }
    const auto vertex = [&](std::size_t k) {
        return set.solid.vertices[3 * random.below(set.solid.vertices.size() / 3) + k];
    };
    if (kind == Kind::mirrored) {
        for (std::size_t pair = 1 + random.below(3); pair > 0; --pair) {
            const std::size_t axis = random.below(3);
            const double side = vertex(axis), distance = decimal(1, 7);
            Vector seed{decimal(-5, 5), decimal(-5, 5), decimal(-5, 5)};
            for (const double sign : {-1, 1}) {
                seed[axis] = side + sign * distance;
                set.points.insert(set.points.end(), seed.begin(), seed.end());
            }
        }
    } else {
        const double step = decimal(2, 7);
        const Vector corner{decimal(-7, 0), decimal(-7, 0), decimal(-7, 0)};
        const std::size_t n = 2 + random.below(2);
        for (std::size_t i = 0; i < n * n * n; ++i)
            for (std::size_t k = 0; k < 3; ++k)
                set.points.push_back(corner[k] +
                                     step * static_cast<double>(std::array{i / n / n, i / n % n, i % n}[k]));
    }
    double size = 1;
    if (kind == Kind::huge) {
        size = std::pow(10, 3 + static_cast<double>(random.below(7)));
        const std::size_t v = 3 * random.below(set.solid.vertices.size() / 3);
        const Vector fixed{set.solid.vertices[v], set.solid.vertices[v + 1], set.solid.vertices[v + 2]};
        for (std::size_t i = 0; i < set.solid.vertices.size(); ++i)
            set.solid.vertices[i] = fixed[i % 3] + (set.solid.vertices[i] - fixed[i % 3]) * size;
    }
    if (kind == Kind::rotated || (kind == Kind::huge && random.chance(0.5))) {
        // The rotation of a quaternion.
        std::array<double, 4> q;
        for (double& x : q) x = random.gaussian();
        const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
        const auto& [w, x, y, z] = q;
        const std::array<Vector, 3> rows{{{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
                                          {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
                                          {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}}};
        for (auto* coordinates : {&set.points, &set.solid.vertices})
            for (std::size_t i = 0; i < coordinates->size(); i += 3) {
                Vector turned{};
                for (std::size_t k = 0; k < 3; ++k)
                    for (std::size_t j = 0; j < 3; ++j) turned[k] += rows[k][j] * (*coordinates)[i + j] / square;
                for (std::size_t k = 0; k < 3; ++k) (*coordinates)[i + k] = turned[k];
            }
    }
    set.reach = 4 * size;
    return set;
}

}  // namespace test

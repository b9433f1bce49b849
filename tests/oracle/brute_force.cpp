#include "oracle/brute_force.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace test {

namespace {

using Vec = std::array<mpz_class, 3>;
using Vertex = std::array<mpz_class, 4>;  // x y z w, w > 0, without common factor: equal points have equal entries
using Polygon = std::vector<Vertex>;

struct Plane {  // n.x <= c
    Vec n;
    mpz_class c;
};

// Coordinates times 2^shift are even integers, so that |n|²/2 is an integer too.
class Scale {
public:
    Scale(std::span<const double> points, const votess::Box& box) {
        int least = std::numeric_limits<int>::max();
        const auto see = [&](double x) {
            int e;
            if (x != 0 && std::frexp(x, &e) != 0) least = std::min(least, e - 53);
        };
        for (const double x : points) see(x);
        for (std::size_t a = 0; a < 3; ++a) {
            see(box.lower[a]);
            see(box.upper[a]);
        }
        shift_ = 1 - least;
    }

    [[nodiscard]] mpz_class integer(double x) const {
        int e;
        mpz_class m(std::ldexp(std::frexp(x, &e), 53));
        if (m != 0) m <<= static_cast<unsigned>(e - 53 + shift_);
        return m;
    }

    // value * 2^(-power * shift)
    [[nodiscard]] mpf_class real(mpf_class value, int power) const {
        const int bits = power * shift_;
        if (bits >= 0)
            value >>= static_cast<unsigned>(bits);
        else
            value <<= static_cast<unsigned>(-bits);
        return value;
    }

private:
    int shift_;
};

Vertex normalized(Vertex v) {
    const mpz_class g = gcd(gcd(v[0], v[1]), gcd(v[2], v[3]));
    for (auto& x : v) mpz_divexact(x.get_mpz_t(), x.get_mpz_t(), g.get_mpz_t());
    return v;
}

// Positive outside; scaled by the w of v.
mpz_class side(const Plane& plane, const Vertex& v) {
    mpz_class s = plane.n[0] * v[0];
    s += plane.n[1] * v[1];
    s += plane.n[2] * v[2];
    s -= plane.c * v[3];
    return s;
}

// Sutherland and Hodgman. Vertices on the plane stay, so a strictly convex polygon stays strictly convex, and one
// that only touches the half-space is left with fewer than three vertices.
void clip(Polygon& polygon, const Plane& plane) {
    std::vector<mpz_class> s;
    s.reserve(polygon.size());
    for (const Vertex& v : polygon) s.push_back(side(plane, v));
    if (std::none_of(s.begin(), s.end(), [](const mpz_class& x) { return x > 0; })) return;
    Polygon kept;
    for (std::size_t a = 0; a < polygon.size(); ++a) {
        const std::size_t b = (a + 1) % polygon.size();
        if (s[a] <= 0) kept.push_back(polygon[a]);
        if (s[a] * s[b] < 0) {
            const bool a_in = s[a] < 0;
            const Vertex &in = a_in ? polygon[a] : polygon[b], &out = a_in ? polygon[b] : polygon[a];
            const mpz_class &s_in = a_in ? s[a] : s[b], &s_out = a_in ? s[b] : s[a];
            Vertex v;
            for (std::size_t k = 0; k < 4; ++k) v[k] = s_out * in[k] - s_in * out[k];
            kept.push_back(normalized(std::move(v)));
        }
    }
    if (kept.size() < 3) kept.clear();
    polygon = std::move(kept);
}

// The part of the plane n.x = c inside the box.
Polygon plane_in_box(const Plane& plane, const Vec& lower, const Vec& upper) {
    std::size_t k = 0;
    for (std::size_t a = 1; a < 3; ++a)
        if (abs(plane.n[a]) > abs(plane.n[k])) k = a;
    const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
    const mpz_class w = abs(plane.n[k]);
    Polygon polygon;
    for (const auto& [at_u, at_v] :
         {std::pair{&lower, &lower}, std::pair{&upper, &lower}, std::pair{&upper, &upper}, std::pair{&lower, &upper}}) {
        Vertex corner;
        corner[u] = (*at_u)[u] * w;
        corner[v] = (*at_v)[v] * w;
        corner[k] = plane.c - plane.n[u] * (*at_u)[u] - plane.n[v] * (*at_v)[v];
        if (plane.n[k] < 0) corner[k] = -corner[k];
        corner[3] = w;
        polygon.push_back(normalized(std::move(corner)));
    }
    Plane above{{0, 0, 0}, upper[k]}, below{{0, 0, 0}, -lower[k]};
    above.n[k] = 1;
    below.n[k] = -1;
    clip(polygon, above);
    if (!polygon.empty()) clip(polygon, below);
    return polygon;
}

Vec difference(const Vec& a, const Vec& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

mpz_class squared(const Vec& n) {
    return n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
}

// Coordinates relative to the first seed: points nearer to it than to the second, n away.
Plane bisector(const Vec& n) {
    return {n, squared(n) / 2};
}

Plane wall_plane(std::int32_t wall, const Vec& lower, const Vec& upper) {
    const auto k = static_cast<std::size_t>((-wall - 1) / 2);
    Plane plane{{0, 0, 0}, 0};
    const bool high = (-wall - 1) % 2 == 1;
    plane.n[k] = high ? 1 : -1;
    plane.c = high ? upper[k] : mpz_class(-lower[k]);
    return plane;
}

mpz_class determinant(const Vertex& a, const Vertex& b, const Vertex& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

mpf_class zero() {
    return {0, precision};
}

mpf_class quotient(const mpz_class& a, const mpz_class& b) {
    const mpf_class x(a, precision), y(b, precision);
    return mpf_class(x / y, precision);
}

// A cell under construction, in integers relative to its seed.
struct Builder {
    std::vector<std::int32_t> faces;
    std::size_t corners = 0;  // over all faces: twice the edges
    std::set<Vertex> vertices;
    mpf_class volume{0, precision};                           // six times
    std::array<mpf_class, 3> moment{zero(), zero(), zero()};  // 24 times

    // Pyramids from the seed, which is never outside of a face's plane, so that all volumes add.
    void add(std::int32_t id, const Polygon& polygon) {
        faces.push_back(id);
        corners += polygon.size();
        vertices.insert(polygon.begin(), polygon.end());
        for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
            const Vertex &a = polygon[0], &b = polygon[k], &c = polygon[k + 1];
            const mpf_class part = quotient(abs(determinant(a, b, c)), a[3] * b[3] * c[3]);
            volume += part;
            for (std::size_t x = 0; x < 3; ++x)
                for (const Vertex* v : {&a, &b, &c}) moment[x] += part * quotient((*v)[x], (*v)[3]);
        }
    }

    ExactCell finish(const Vec& seed, const Scale& scale) {
        ExactCell cell;
        std::sort(faces.begin(), faces.end());
        cell.faces = std::move(faces);
        cell.edges = corners / 2;
        cell.vertices = vertices.size();
        cell.volume = scale.real(volume / 6, 3);
        for (std::size_t x = 0; x < 3; ++x) {
            cell.centroid[x] = scale.real(moment[x] / (4 * volume) + quotient(seed[x], 1), 1);
            mpf_class low(0, precision), high(0, precision);  // the seed is in its cell
            for (const Vertex& v : vertices) {
                const mpf_class at = quotient(v[x], v[3]);
                if (at < low) low = at;
                if (at > high) high = at;
            }
            cell.extent[x] = scale.real(high - low, 1).get_d();
        }
        return cell;
    }
};

}  // namespace

mpf_class exact_volume(const votess::Box& box) {
    mpf_class volume(1, precision);
    for (std::size_t a = 0; a < 3; ++a)
        volume *= mpf_class(mpf_class(box.upper[a], precision) - box.lower[a], precision);
    return volume;
}

ExactDiagram brute_force(std::span<const double> points, const votess::Box& box) {
    const std::size_t n = points.size() / 3;
    const Scale scale(points, box);
    std::vector<Vec> seed(n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t a = 0; a < 3; ++a) seed[i][a] = scale.integer(points[3 * i + a]);

    mpf_set_default_prec(precision);  // of temporaries
    ExactDiagram diagram;
    diagram.cells.resize(n);
    diagram.duplicate_of.assign(n, -1);
    std::vector<std::size_t> distinct;
    for (std::size_t i = 0; i < n; ++i) {
        const auto same =
            std::find_if(distinct.begin(), distinct.end(), [&](std::size_t j) { return seed[j] == seed[i]; });
        if (same == distinct.end())
            distinct.push_back(i);
        else
            diagram.duplicate_of[i] = static_cast<std::int32_t>(*same);
    }

    std::vector<Builder> builders(n);
    for (const std::size_t i : distinct) {
        Vec lower, upper;
        for (std::size_t a = 0; a < 3; ++a) {
            lower[a] = scale.integer(box.lower[a]) - seed[i][a];
            upper[a] = scale.integer(box.upper[a]) - seed[i][a];
        }
        std::vector<std::pair<Plane, std::int32_t>> others;  // nearest first: kills most polygons soon
        for (const std::size_t j : distinct)
            if (j != i) others.emplace_back(bisector(difference(seed[j], seed[i])), static_cast<std::int32_t>(j));
        std::sort(others.begin(), others.end(), [](const auto& a, const auto& b) { return a.first.c < b.first.c; });

        const auto face = [&](const Plane& plane, std::int32_t id) {
            Polygon polygon = plane_in_box(plane, lower, upper);
            for (const auto& [other, j] : others) {
                if (polygon.empty()) break;
                if (j != id) clip(polygon, other);
            }
            return polygon;
        };
        for (std::int32_t wall = -6; wall < 0; ++wall) {
            const Polygon polygon = face(wall_plane(wall, lower, upper), wall);
            if (!polygon.empty()) builders[i].add(wall, polygon);
        }
        for (const auto& [plane, j] : others) {
            if (static_cast<std::size_t>(j) < i) continue;
            Polygon polygon = face(plane, j);
            if (polygon.empty()) continue;
            builders[i].add(j, polygon);
            for (Vertex& v : polygon)
                for (std::size_t a = 0; a < 3; ++a)
                    v[a] -= plane.n[a] * v[3];  // seen from j; still without common factor
            builders[static_cast<std::size_t>(j)].add(static_cast<std::int32_t>(i), polygon);
        }
    }
    for (const std::size_t i : distinct) diagram.cells[i] = builders[i].finish(seed[i], scale);
    return diagram;
}

bool exact_face(std::span<const double> points, const votess::Box& box, std::size_t i, std::int32_t j) {
    const std::size_t n = points.size() / 3;
    const Scale scale(points, box);
    const auto integers = [&](const double* p) {
        return Vec{scale.integer(p[0]), scale.integer(p[1]), scale.integer(p[2])};
    };
    const Vec seed = integers(&points[3 * i]);
    const Vec lower = difference(integers(box.lower.data()), seed),
              upper = difference(integers(box.upper.data()), seed);
    const auto plane_of = [&](std::size_t k) { return bisector(difference(integers(&points[3 * k]), seed)); };

    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t k = 0; k < n; ++k) {
        const double dx = points[3 * k] - points[3 * i], dy = points[3 * k + 1] - points[3 * i + 1],
                     dz = points[3 * k + 2] - points[3 * i + 2];
        if (k != i && static_cast<std::int64_t>(k) != j && (dx != 0 || dy != 0 || dz != 0))
            order.emplace_back(std::sqrt(dx * dx + dy * dy + dz * dz), k);
    }
    std::sort(order.begin(), order.end());

    Polygon polygon =
        plane_in_box(j < 0 ? wall_plane(j, lower, upper) : plane_of(static_cast<std::size_t>(j)), lower, upper);
    const auto reach = [&] {
        double farthest = 0;
        for (const Vertex& v : polygon) {
            double sum = 0;
            for (std::size_t a = 0; a < 3; ++a) {
                const double x = scale.real(quotient(v[a], v[3]), 1).get_d();
                sum += x * x;
            }
            farthest = std::max(farthest, std::sqrt(sum));
        }
        return 2 * farthest * (1 + 1e-9);  // more than the rounding here and of the sorted distances
    };
    double limit = reach();
    for (const auto& [distance, k] : order) {
        if (polygon.empty() || distance > limit) break;
        const std::size_t before = polygon.size();
        const Vertex first = polygon[0];
        clip(polygon, plane_of(k));
        if (!polygon.empty() && (polygon.size() != before || polygon[0] != first)) limit = reach();
    }
    return !polygon.empty();
}

}  // namespace test

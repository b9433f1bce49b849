#include "solid/inside.hpp"

#include <algorithm>
#include <cmath>

#include "core/arithmetic.hpp"
#include "core/vector3.hpp"
#include "exact/integer/big_int.hpp"
#include "exact/integer/rows.hpp"
#include "exact/quad.hpp"
#include "solid/mesh_signs.hpp"

namespace votess::solid {
namespace {

using exact::BigInt;
using exact::Plane;
using exact::Point;
using exact::Ray;
using exact::Shift;
using Integers = std::array<BigInt, 3>;
using Corners = std::array<const Point*, 3>;

constexpr double coordinate_rounding = 0x1p-48;  // of a coordinate
constexpr double time_rounding = 0x1p-48;        // of a time, or of a coordinate
constexpr double det_rounding = 24 * unit;       // of the products in a determinant of differences
constexpr double near_side = 1e-6;               // of a periodic domain: images on both sides may hold a place
constexpr Point upward{0, 0, 1};

std::array<double, 3> difference(const Point& u, const Plane& image) {
    if (image.lattice == nullptr) return minus(u, image.seed);
    const auto d = exact::image_differences(u, image).x;
    return {-d[0].high, -d[1].high, -d[2].high};
}

Point rounded(const Plane& image) {
    if (image.lattice == nullptr) return image.seed;
    const auto d = exact::image_differences({}, image).x;
    return {d[0].high, d[1].high, d[2].high};
}

// A determinant of three rows, and a bound on its error where rows err by a few units in the last place.
struct Det {
    double value, error;

    Det(const Vector3& a, const Vector3& b, const Vector3& c) {
        value = error = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
            value += a[i] * (b[j] * c[k] - b[k] * c[j]);
            error += std::abs(a[i]) * (std::abs(b[j] * c[k]) + std::abs(b[k] * c[j]));
        }
        error = det_rounding * error + tiny;
    }
    [[nodiscard]] bool sure() const { return std::abs(value) > error; }
    [[nodiscard]] int sign() const { return value > 0 ? 1 : -1; }
};

// Whole numbers in place of coordinates relative to an image of a place.
class Whole {
public:
    Whole(const Plane& image, std::span<const Point* const> points) {
        exact::BitRange range;
        range.add(image);
        for (const Point* x : points) range.add(*x);
        quantum_ = range.quantum();
        for (std::size_t i = 0; i < points.size(); ++i)
            x_[i] = range.span() <= exact::middle_bits ? relative<exact::middle>(*points[i], image)
                                                       : relative<exact::widest>(*points[i], image);
    }
    [[nodiscard]] const Integers& operator[](std::size_t i) const { return x_[i]; }
    [[nodiscard]] int quantum() const { return quantum_; }

private:
    template <int W>
    [[nodiscard]] Integers relative(const Point& x, const Plane& image) const {
        const auto d = exact::wide_difference<W>(x, image, quantum_);
        return {-BigInt(d[0]), -BigInt(d[1]), -BigInt(d[2])};
    }

    std::array<Integers, 3> x_;
    int quantum_ = 0;
};

struct WholeVector {
    Integers x;
    int quantum;

    explicit WholeVector(const Point& d) {
        exact::BitRange range;
        range.add(d);
        quantum = range.quantum();
        for (std::size_t k = 0; k < 3; ++k) x[k] = BigInt(exact::to_wide<exact::widest>(d[k], quantum));
    }
};

Integers edge(const Integers& from, const Integers& to) {
    return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}
int first_sign(const Integers& x) {
    for (const BigInt& component : x)
        if (component.sign() != 0) return component.sign();
    return 0;
}

// Returns the side on which a line passes an edge; 0 only for an edge along the line, or without ties.
int edge_side(const Point& d, const Plane& origin, const Point& u, const Point& v, bool ties) {
    if (const Det det(d, difference(u, origin), difference(v, origin)); det.sure()) return det.sign();
    const std::array<const Point*, 2> points{&u, &v};
    const Whole x(origin, points);
    const WholeVector along(d);
    const int sign = dot(along.x, cross(x[0], x[1])).sign();
    return sign != 0 || !ties ? sign : first_sign(cross(edge(x[0], x[1]), along.x));
}

// Returns the sign of n.(u - o).
int plane_side(const Plane& origin, const Corners& t, bool ties) {
    if (const Det det(difference(*t[0], origin), difference(*t[1], origin), difference(*t[2], origin)); det.sure())
        return det.sign();
    const Whole x(origin, t);
    const int sign = dot(x[0], cross(x[1], x[2])).sign();
    return sign != 0 || !ties ? sign : first_sign(cross(edge(x[0], x[1]), edge(x[0], x[2])));
}

// The time of a crossing as a quotient.
struct WholeTime {
    BigInt over, under;  // under is positive
    int quantum;

    WholeTime(const Point& d, const Plane& origin, const Corners& t) {
        const Whole x(origin, t);
        const WholeVector along(d);
        over = dot(x[0], cross(x[1], x[2]));
        under = dot(along.x, cross(edge(x[0], x[1]), edge(x[0], x[2])));
        if (under.sign() < 0) over = -over, under = -under;
        quantum = x.quantum() - along.quantum;
    }
    [[nodiscard]] double rounded() const {
        if (over.sign() == 0) return 0;
        return static_cast<double>(ldexp(static_cast<exact::Quad>(over) / static_cast<exact::Quad>(under), quantum));
    }
};

BigInt shifted(BigInt x, int bits) {
    constexpr int step = 32;
    for (; bits >= step; bits -= step) x = x * BigInt(std::int64_t{1} << step);
    return x * BigInt(std::int64_t{1} << bits);
}

bool earlier(const WholeTime& a, const WholeTime& b) {
    const int least = std::min(a.quantum, b.quantum);
    return (shifted(a.over * b.under, a.quantum - least) - shifted(b.over * a.under, b.quantum - least)).sign() < 0;
}

// Returns the time and its bound; false if that is too large.
bool near_time(const Point& d, const Plane& origin, const Corners& t, double size, double& time) {
    const Vector3 a = difference(*t[0], origin), b = difference(*t[1], origin), c = difference(*t[2], origin);
    const Det over(a, b, c), under(d, minus(*t[1], *t[0]), minus(*t[2], *t[0]));
    time = over.value / under.value;
    const double error = (over.error + std::abs(time) * under.error) / (std::abs(under.value) - under.error);
    return std::abs(under.value) > 2 * under.error && error <= time_rounding * (std::abs(time) + size);
}

// Returns whether a ray misses a box for sure.
bool misses(const Box& box, const Point& from, const Point& d, double slack) {
    double begin = 0, end = infinity;
    for (std::size_t k = 0; k < 3; ++k) {
        const double low = box.lower[k] - slack - from[k], high = box.upper[k] + slack - from[k];
        if (d[k] == 0) {
            if (low > 0 || high < 0) return true;
            continue;
        }
        begin = std::max(begin, std::min(low / d[k], high / d[k]) * (1 - coordinate_rounding));
        end = std::min(end, std::max(low / d[k], high / d[k]) * (1 + coordinate_rounding));
    }
    return begin > end;
}

double size_of(const Box& box, const Point& x) {
    double size = 0;
    for (std::size_t k = 0; k < 3; ++k)
        size = std::max({size, std::abs(box.lower[k]), std::abs(box.upper[k]), std::abs(x[k])});
    return size;
}

Corners corners_of(const ClosedMesh& mesh, std::uint32_t t) {
    const auto& vertex = mesh.triangles()[t].vertex;
    return {&mesh.vertex(vertex[0]), &mesh.vertex(vertex[1]), &mesh.vertex(vertex[2])};
}

}  // namespace

void Inside::add_crossings(const Ray& ray, const Plane& image, int number, std::vector<Crossing>& to) const {
    const Point from = rounded(image);
    const double size = size_of(mesh_.placed(), from), slack = coordinate_rounding * size;
    const auto visit = [&](std::uint32_t t) {
        const Corners c = corners_of(mesh_, t);
        const int sign = edge_side(ray.direction, image, *c[0], *c[1], true);
        if (sign == 0 || edge_side(ray.direction, image, *c[1], *c[2], true) != sign ||
            edge_side(ray.direction, image, *c[2], *c[0], true) != sign || plane_side(image, c, true) != sign)
            return true;
        Crossing crossing{0, t, sign, number};
        if (!near_time(ray.direction, image, c, size, crossing.time))
            crossing.time = WholeTime(ray.direction, image, c).rounded();
        crossing.time = std::max(crossing.time, 0.0);
        to.push_back(crossing);
        return true;
    };
    mesh_.for_each_in(mesh_.placed(), visit, [&](const Box& box) { return misses(box, from, ray.direction, slack); });
}

bool Inside::on_surface(const Plane& image) const {
    const Point x = rounded(image);
    const double slack = coordinate_rounding * size_of(mesh_.placed(), x);
    Box around{x, x};
    for (std::size_t k = 0; k < 3; ++k) around.lower[k] -= slack, around.upper[k] += slack;
    bool found = false;
    mesh_.for_each_in(around, [&](std::uint32_t t) {
        const Corners c = corners_of(mesh_, t);
        if (plane_side(image, c, false) != 0) return true;
        for (int axis = 0; axis < 3 && !found; ++axis) {
            if (cross_sign(*c[0], *c[1], *c[2], axis) == 0) continue;
            Point d{};
            d[static_cast<std::size_t>(axis)] = 1;
            const int a = edge_side(d, image, *c[0], *c[1], false), b = edge_side(d, image, *c[1], *c[2], false),
                      e = edge_side(d, image, *c[2], *c[0], false);
            found = std::min({a, b, e}) >= 0 || std::max({a, b, e}) <= 0;
            break;
        }
        return !found;
    });
    return found;
}

bool Inside::holds(const Point& x) const {
    Shift home{};
    if (domain_->is_periodic()) {
        const auto wrapped = wrap(*domain_, x);
        if (!wrapped) return false;
        home = *wrapped;
    }
    std::array<int, 3> reach{};  // the mesh may touch images of itself
    for (std::size_t j = 0; j < 3; ++j) reach[j] = domain_->periodic[j] ? 1 : 0;
    int winding = 0;
    std::vector<Crossing> crossings;
    for (int a = -reach[0]; a <= reach[0]; ++a)
        for (int b = -reach[1]; b <= reach[1]; ++b)
            for (int c = -reach[2]; c <= reach[2]; ++c) {
                const Plane image = image_of(x, {home[0] + a, home[1] + b, home[2] + c});
                const Point at = rounded(image);
                const Box& box = mesh_.placed();
                const double slack = coordinate_rounding * size_of(box, at);
                bool is_near = true;
                for (std::size_t k = 0; k < 3; ++k)
                    is_near &= at[k] >= box.lower[k] - slack && at[k] <= box.upper[k] + slack;
                if (!is_near) continue;
                if (on_surface(image)) return true;
                crossings.clear();
                add_crossings({x, upward}, image, 0, crossings);
                for (const Crossing& crossing : crossings) winding += crossing.sign;
            }
    return winding != 0;
}

// Returns shifts that may bring a place of the ray into the mesh. They divide the ray where it enters a cell of the
// lattice.
std::vector<Shift> Inside::shifts_along(const Ray& ray, double end) const {
    if (!domain_->is_periodic()) return {Shift{}};
    Point to;
    for (std::size_t k = 0; k < 3; ++k) to[k] = ray.origin[k] + end * ray.direction[k];
    const Vector3 first = domain_->fraction(ray.origin), last = domain_->fraction(to);
    std::vector<double> steps{0, 1};  // shares of the ray
    for (std::size_t j = 0; j < 3; ++j) {
        if (!domain_->periodic[j]) continue;
        const double low = std::min(first[j], last[j]), high = std::max(first[j], last[j]);
        for (double f = std::ceil(low); f <= high && high > low; ++f)
            steps.push_back((f - first[j]) / (last[j] - first[j]));
    }
    std::ranges::sort(steps);
    std::vector<Shift> shifts;
    for (const double step : steps) {
        std::array<std::array<std::int32_t, 2>, 3> cells{};
        for (std::size_t j = 0; j < 3; ++j) {
            if (!domain_->periodic[j]) continue;
            const double f = first[j] + step * (last[j] - first[j]), slack = near_side + 0x1p-45 * std::abs(f);
            cells[j] = {static_cast<std::int32_t>(std::floor(f - slack)),
                        static_cast<std::int32_t>(std::floor(f + slack))};
        }
        for (std::int32_t a = cells[0][0]; a <= cells[0][1]; ++a)
            for (std::int32_t b = cells[1][0]; b <= cells[1][1]; ++b)
                for (std::int32_t c = cells[2][0]; c <= cells[2][1]; ++c) shifts.push_back({-a, -b, -c});
    }
    std::ranges::sort(shifts);
    const auto rest = std::ranges::unique(shifts);
    shifts.erase(rest.begin(), rest.end());
    return shifts;
}

std::vector<Inside::Part> Inside::parts(const Ray& ray, double end) const {
    std::vector<Plane> images;
    std::vector<Crossing> crossings;
    for (const Shift& shift : shifts_along(ray, end)) {
        images.push_back(image_of(ray.origin, shift));
        add_crossings(ray, images.back(), static_cast<int>(images.size()) - 1, crossings);
    }
    const auto exactly_before = [&](const Crossing& a, const Crossing& b) {
        const auto time = [&](const Crossing& x) {
            return WholeTime(ray.direction, images[static_cast<std::size_t>(x.of_image)],
                             corners_of(mesh_, x.triangle));
        };
        return earlier(time(a), time(b));
    };
    const double size = size_of(mesh_.placed(), ray.origin);
    const auto are_near = [&](const Crossing& a, const Crossing& b) {
        return std::abs(a.time - b.time) <= 4 * time_rounding * (std::abs(a.time) + std::abs(b.time) + size);
    };
    std::ranges::sort(crossings, {}, &Crossing::time);
    // Rounding may have changed the order of near ones.
    for (std::size_t begin = 0, next = 0; begin < crossings.size(); begin = next) {
        for (next = begin + 1; next < crossings.size() && are_near(crossings[next - 1], crossings[next]);) ++next;
        if (next - begin > 1)
            std::sort(crossings.begin() + static_cast<std::ptrdiff_t>(begin),
                      crossings.begin() + static_cast<std::ptrdiff_t>(next), exactly_before);
    }
    int winding = 0;
    for (const Crossing& crossing : crossings) winding += crossing.sign;
    std::vector<Part> parts;
    if (winding != 0) parts.push_back({0, end});
    for (std::size_t begin = 0, next = 0; begin < crossings.size(); begin = next) {
        const double time = crossings[begin].time;
        if (time >= end) break;
        const bool was_inside = winding != 0;
        for (next = begin; next < crossings.size(); ++next) {
            if (next > begin &&
                (!are_near(crossings[begin], crossings[next]) || exactly_before(crossings[begin], crossings[next])))
                break;
            winding -= crossings[next].sign;
        }
        if (was_inside && winding == 0) parts.back().end = std::max(time, parts.back().begin);
        if (!was_inside && winding != 0) parts.push_back({time, end});
    }
    return parts;
}

}  // namespace votess::solid

#include "oracle/half_spaces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include "oracle/exact_polygons.hpp"
#include "oracle/integer_domain.hpp"
#include "support/text.hpp"

namespace test {
namespace {

using Vec = RationalVector;
using Polygon = std::vector<Vec>;

struct HalfSpace {  // n.x <= h
    Vec n;
    mpq_class h;
    ExactFace face;
    bool bisector = false;
    std::array<double, 3> rounded_n;  // of length one
    double rounded_h = 0;
};

// The plane inside a cube of that half width.
Polygon begin_polygon(const HalfSpace& plane, const mpq_class& width) {
    std::size_t k = 0;
    for (std::size_t a = 1; a < 3; ++a)
        if (abs(plane.n[a]) > abs(plane.n[k])) k = a;
    const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
    Polygon polygon;
    for (const auto& [at_u, at_v] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}}) {
        Vec corner;
        corner[u] = at_u * width;
        corner[v] = at_v * width;
        corner[k] = (plane.h - plane.n[u] * corner[u] - plane.n[v] * corner[v]) / plane.n[k];
        polygon.push_back(corner);
    }
    return polygon;
}

// Normals as short as the smallest double are multiplied by a power of two first.
void round_plane(HalfSpace& plane) {
    Vec n = plane.n;
    mpq_class h = plane.h;
    const auto times_two_to = [](mpq_class& x, long power) {
        if (power >= 0)
            mpq_mul_2exp(x.get_mpq_t(), x.get_mpq_t(), static_cast<mp_bitcnt_t>(power));
        else
            mpq_div_2exp(x.get_mpq_t(), x.get_mpq_t(), static_cast<mp_bitcnt_t>(-power));
    };
    const mpq_class square = dot(n, n);
    const auto bits = [](const mpz_class& x) { return static_cast<long>(mpz_sizeinbase(x.get_mpz_t(), 2)); };
    const long power = (bits(square.get_den()) - bits(square.get_num())) / 2;
    for (mpq_class& x : n) times_two_to(x, power);
    times_two_to(h, power);
    const double length = std::sqrt(dot(n, n).get_d());
    for (std::size_t k = 0; k < 3; ++k) plane.rounded_n[k] = n[k].get_d() / length;
    plane.rounded_h = h.get_d() / length;
}

// Most planes are far from the cell, which floating point can tell: clips by half-spaces moved outward by more than all
// rounding. True: the exact polygon is empty.
bool surely_empty(const std::vector<HalfSpace>& all, std::size_t plane, double width, double cube) {
    const auto& n = all[plane].rounded_n;
    const double h = all[plane].rounded_h;
    std::size_t k = 0;
    for (std::size_t a = 1; a < 3; ++a)
        if (std::abs(n[a]) > std::abs(n[k])) k = a;
    const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
    std::vector<std::array<double, 3>> polygon, kept;
    for (const auto& [at_u, at_v] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}}) {
        std::array<double, 3> corner;
        corner[u] = at_u * cube;
        corner[v] = at_v * cube;
        corner[k] = (h - n[u] * corner[u] - n[v] * corner[v]) / n[k];
        polygon.push_back(corner);
    }
    const double outward = 1e-7 * width;
    for (std::size_t o = 0; o < all.size() && !polygon.empty(); ++o) {
        if (o == plane) continue;
        const auto side = [&](const std::array<double, 3>& x) {
            const auto& m = all[o].rounded_n;
            return m[0] * x[0] + m[1] * x[1] + m[2] * x[2] - all[o].rounded_h - outward;
        };
        kept.clear();
        for (std::size_t a = 0; a < polygon.size(); ++a) {
            const auto &from = polygon[a], &to = polygon[(a + 1) % polygon.size()];
            const double s = side(from), t = side(to);
            if (s <= 0) kept.push_back(from);
            if ((s > 0) == (t > 0)) continue;
            std::array<double, 3> x;
            for (std::size_t axis = 0; axis < 3; ++axis) x[axis] = from[axis] + s / (s - t) * (to[axis] - from[axis]);
            kept.push_back(x);
        }
        polygon.swap(kept);
    }
    return polygon.empty();
}

// The same plane, seen from the same side.
bool coincide(const HalfSpace& a, const HalfSpace& b) {
    const Vec turned = cross(a.n, b.n);
    if (turned[0] != 0 || turned[1] != 0 || turned[2] != 0 || dot(a.n, b.n) <= 0) return false;
    return a.h * dot(b.n, b.n) == b.h * dot(a.n, b.n);
}

Vec exact(const std::array<double, 3>& x) {
    return {mpq_class(x[0]), mpq_class(x[1]), mpq_class(x[2])};
}

const std::array<bool, 3>& periodic_axes(const votess::Options& options) {
    return options.cell ? options.cell->periodic : options.periodic;
}

std::array<Vec, 3> vectors_of(const votess::Options& options) {
    std::array<Vec, 3> vectors;
    if (options.cell) return {exact(options.cell->a), exact(options.cell->b), exact(options.cell->c)};
    for (std::size_t k = 0; k < 3; ++k)
        if (options.periodic[k]) vectors[k][k] = mpq_class(options.box->upper[k]) - mpq_class(options.box->lower[k]);
    return vectors;
}

// Where the seed lies inside a periodic domain.
Vec wrapped(Vec x, const votess::Options& options, const std::array<Vec, 3>& vectors) {
    const Vec origin = exact(options.cell ? options.cell->origin : options.box->lower);
    for (std::size_t j = 0; j < 3; ++j) {
        if (!periodic_axes(options)[j]) continue;
        const Vec across = options.cell ? cross(vectors[(j + 1) % 3], vectors[(j + 2) % 3]) : vectors[j];
        const Vec from{x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]};
        const mpq_class f = dot(from, across) / dot(vectors[j], across);
        mpz_class whole;
        mpz_fdiv_q(whole.get_mpz_t(), f.get_num_mpz_t(), f.get_den_mpz_t());
        for (std::size_t k = 0; k < 3; ++k) x[k] -= whole * vectors[j][k];
    }
    return x;
}

std::vector<HalfSpace> half_spaces(std::span<const double> points, const votess::Options& options, std::size_t i,
                                   std::optional<int> reach) {
    const auto vectors = vectors_of(options);
    const auto at = [&](std::size_t j) {
        return wrapped(exact({points[3 * j], points[3 * j + 1], points[3 * j + 2]}), options, vectors);
    };
    const auto weight = [&](std::size_t j) {
        return options.weights.empty() ? mpq_class(0) : mpq_class(options.weights[j]);
    };
    const Vec p = at(i);
    std::vector<HalfSpace> all;
    const IntegerDomain domain(points, options);
    const auto shifts_of = [&](std::size_t j) {
        if (!reach) return domain.near_shifts(i, j);
        std::array<int, 3> range{};
        for (std::size_t k = 0; k < 3; ++k) range[k] = periodic_axes(options)[k] ? *reach : 0;
        std::vector<std::array<int, 3>> shifts;
        for (int a = -range[0]; a <= range[0]; ++a)
            for (int b = -range[1]; b <= range[1]; ++b)
                for (int c = -range[2]; c <= range[2]; ++c) shifts.push_back({a, b, c});
        return shifts;
    };
    for (std::size_t j = 0; j < points.size() / 3; ++j) {
        if (domain.is_outside(j)) continue;
        const Vec q = at(j);
        for (const auto& shift : shifts_of(j)) {
            if (j == i && shift == std::array<int, 3>{}) continue;
            HalfSpace s;
            s.face = {static_cast<std::int32_t>(j), shift};
            for (std::size_t k = 0; k < 3; ++k)
                s.n[k] = q[k] - p[k] + shift[0] * vectors[0][k] + shift[1] * vectors[1][k] + shift[2] * vectors[2][k];
            s.h = (dot(s.n, s.n) + weight(i) - weight(j)) / 2;
            s.bisector = true;
            all.push_back(std::move(s));
        }
    }
    for (std::size_t k = 0; k < 3; ++k) {
        if (periodic_axes(options)[k]) continue;
        for (const int sign : {-1, 1}) {
            HalfSpace s;
            s.face.id = -1 - static_cast<std::int32_t>(2 * k) - (sign > 0 ? 1 : 0);
            if (options.cell) {
                s.n = cross(vectors[(k + 1) % 3], vectors[(k + 2) % 3]);
                const int outward = sign * sgn(dot(vectors[k], s.n));
                const Vec origin = exact(options.cell->origin);
                for (std::size_t x = 0; x < 3; ++x) {
                    s.n[x] *= outward;
                    s.h += s.n[x] * (origin[x] + (sign > 0 ? vectors[k][x] : mpq_class(0)) - p[x]);
                }
            } else {
                s.n[k] = sign;
                s.h = sign * (mpq_class(sign > 0 ? options.box->upper[k] : options.box->lower[k]) - p[k]);
            }
            all.push_back(std::move(s));
        }
    }
    for (std::size_t w = 0; w < options.walls.size(); ++w) {
        HalfSpace s;
        s.face.id = -7 - static_cast<std::int32_t>(w);
        s.n = exact(options.walls[w].normal);
        s.h = mpq_class(options.walls[w].offset) - dot(s.n, p);
        all.push_back(std::move(s));
    }
    return all;
}

// Returns the relative error of volumes: in single precision 1e-5, else this.
double promise(const votess::Tessellation& t, double in_double) {
    return t.stats().precision == votess::Precision::single ? 1e-5 : in_double;
}

}  // namespace

mpq_class dot(const Vec& a, const Vec& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vec cross(const Vec& a, const Vec& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

void clip(Polygon& polygon, const Vec& n, const mpq_class& h) {
    std::vector<mpq_class> s;
    for (const Vec& v : polygon) s.push_back(dot(n, v) - h);
    if (std::ranges::none_of(s, [](const mpq_class& x) { return x > 0; })) return;
    Polygon kept;
    for (std::size_t a = 0; a < polygon.size(); ++a) {
        const std::size_t b = (a + 1) % polygon.size();
        if (s[a] <= 0) kept.push_back(polygon[a]);
        if (sgn(s[a]) * sgn(s[b]) >= 0) continue;
        const mpq_class t = s[a] / (s[a] - s[b]);
        Vec v;
        for (std::size_t k = 0; k < 3; ++k) v[k] = polygon[a][k] + t * (polygon[b][k] - polygon[a][k]);
        kept.push_back(std::move(v));
    }
    if (kept.size() < 3) kept.clear();
    polygon = std::move(kept);
}

Vec doubled_area(const Polygon& polygon) {
    Vec area{0, 0, 0};
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
        Vec a, b;
        for (std::size_t x = 0; x < 3; ++x) {
            a[x] = polygon[k][x] - polygon[0][x];
            b[x] = polygon[k + 1][x] - polygon[0][x];
        }
        const Vec part = cross(a, b);
        for (std::size_t x = 0; x < 3; ++x) area[x] += part[x];
    }
    return area;
}

std::vector<ExactPolygon> exact_polygons(std::span<const double> points, const votess::Options& options, std::size_t i,
                                         std::optional<int> reach) {
    std::vector<HalfSpace> all = half_spaces(points, options, i, reach);
    std::vector<ExactPolygon> polygons;
    // A seed at the same place leaves all or nothing.
    const auto place = [](const HalfSpace& s) { return s.n[0] == 0 && s.n[1] == 0 && s.n[2] == 0; };
    if (std::ranges::any_of(all, [&](const HalfSpace& s) { return place(s) && s.h < 0; })) return {};
    std::erase_if(all, place);
    double width = 1;
    for (HalfSpace& s : all) {
        round_plane(s);
        // Walls and the images of the seed itself bound the cell; bisectors of weighted seeds may lie at any distance.
        if (!s.bisector || s.face.id == static_cast<std::int32_t>(i)) width = std::max(width, std::abs(s.rounded_h));
    }
    std::ranges::sort(all, {}, [](const HalfSpace& s) { return s.rounded_h; });
    const double cube = std::ldexp(1.0, std::ilogb(width) + 12);
    for (std::size_t index = 0; index < all.size(); ++index) {
        if (surely_empty(all, index, width, cube)) continue;
        const HalfSpace& s = all[index];
        // Of equal planes the face is the wall's, of walls the first one's; of seeds that of the farthest behind:
        // beyond the plane it is the nearest.
        const bool may_coincide =
            !options.weights.empty() || !options.walls.empty() || options.outside == votess::Outside::keep;
        const bool hidden = may_coincide && std::ranges::any_of(all, [&](const HalfSpace& other) {
                                if (&other == &s || !coincide(s, other)) return false;
                                if (other.bisector != s.bisector) return s.bisector;
                                return s.bisector ? dot(other.n, other.n) > dot(s.n, s.n) : other.face.id > s.face.id;
                            });
        if (hidden) continue;
        Polygon polygon = begin_polygon(s, mpq_class(cube));
        for (const HalfSpace& other : all) {
            if (polygon.empty()) break;
            if (&other != &s) clip(polygon, other.n, other.h);
        }
        if (polygon.empty()) continue;
        if (dot(doubled_area(polygon), s.n) < 0) std::ranges::reverse(polygon);
        polygons.push_back({s.face, s.n, s.h, std::move(polygon)});
    }
    std::ranges::sort(polygons, {}, &ExactPolygon::face);
    if (polygons.size() < 4) return {};
    return polygons;
}

ExactDomainCell exact_cell(std::span<const double> points, const votess::Options& options, std::size_t i,
                           std::optional<int> reach) {
    ExactDomainCell cell;
    mpq_class volume;
    for (const ExactPolygon& p : exact_polygons(points, options, i, reach)) {
        cell.faces.push_back(p.face);
        // Exactly: pyramids of a seed outside of its cell cancel.
        volume += dot(doubled_area(p.corners), p.n) * p.h / dot(p.n, p.n) / 6;
    }
    cell.volume = volume.get_d();
    return cell;
}

std::string check_against_half_spaces(const votess::Tessellation& t, std::span<const double> points,
                                      const votess::Options& options, std::optional<int> reach) {
    const auto line = [](const std::vector<ExactFace>& faces) {
        std::string all;
        for (const auto& [id, s] : faces)
            all += s == std::array<int, 3>{} ? text(' ', id) : text(' ', id, '(', s[0], ',', s[1], ',', s[2], ')');
        return all;
    };
    const IntegerDomain domain(points, options);
    for (std::size_t i = 0; i < t.size(); ++i) {
        const auto row = t.neighbors(i);
        if (domain.is_outside(i) != (t.status()[i] == votess::CellStatus::outside))
            return text("cell ", i, " lies outside, or not, but is told otherwise");
        if (domain.is_outside(i)) {
            if (!row.empty()) return text("cell ", i, " lies outside, but has neighbors");
            continue;
        }
        const ExactDomainCell expected = exact_cell(points, options, i, reach);
        std::vector<ExactFace> faces;
        for (std::size_t k = 0; k < row.size(); ++k) {
            ExactFace face{row[k], {}};
            if (!t.shifts().empty())
                std::copy_n(t.shifts().data() + 3 * (static_cast<std::size_t>(t.indptr()[i]) + k), 3,
                            face.shift.begin());
            faces.push_back(face);
        }
        if (faces != expected.faces)
            return "cell " + std::to_string(i) + " has" + line(faces) + ", exact are" + line(expected.faces);
        const bool empty = t.status()[i] == votess::CellStatus::empty;
        if (empty != expected.faces.empty()) return "cell " + std::to_string(i) + " has the wrong status";
        if (!(std::abs(t.volumes()[i] - expected.volume) <= promise(t, 1e-10) * expected.volume))
            return text("cell ", i, " has volume ", t.volumes()[i], ", exact is ", expected.volume);
    }
    return "";
}

std::string check_domain(const votess::Tessellation& t) {
    const auto& stats = t.stats();
    // With no seed inside, no cell fills the domain.
    const bool any = std::ranges::find(t.status(), votess::CellStatus::certified) != t.status().end();
    // Subnormal volumes are rounded to a multiple of the least double.
    const double rounding = static_cast<double>(t.size() + 1) * std::numeric_limits<double>::denorm_min();
    if (!(std::abs(stats.volume_sum - (any ? stats.box_volume : 0)) <= promise(t, 1e-9) * stats.box_volume + rounding))
        return text("volumes sum to ", stats.volume_sum, " of ", stats.box_volume);
    std::set<std::tuple<std::int32_t, std::int32_t, int, int, int>> faces;
    for (std::size_t i = 0; i < t.size(); ++i) {
        const auto row = t.neighbors(i);
        const bool gone = t.status()[i] != votess::CellStatus::certified;
        if (gone && (!row.empty() || t.volumes()[i] != 0)) return "cell " + std::to_string(i) + " is not empty";
        for (std::size_t k = 0; k < row.size(); ++k) {
            std::array<int, 3> s{};
            if (!t.shifts().empty())
                std::copy_n(t.shifts().data() + 3 * (static_cast<std::size_t>(t.indptr()[i]) + k), 3, s.begin());
            if (!faces.emplace(static_cast<std::int32_t>(i), row[k], s[0], s[1], s[2]).second)
                return "cell " + std::to_string(i) + " lists a face twice";
        }
    }
    for (const auto& [i, j, a, b, c] : faces)
        if (j >= 0 && !faces.contains({j, i, -a, -b, -c}))
            return "cell " + std::to_string(i) + " lists " + std::to_string(j) + ", which does not list it back";
    return "";
}

}  // namespace test

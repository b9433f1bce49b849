#include "oracle/half_spaces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "oracle/exact_polygons.hpp"
#include "oracle/integer_domain.hpp"
#include "support/text.hpp"

namespace test {
namespace {

template <class Real>
using Polygon = std::vector<VectorOf<Real>>;

// A plane with a normal of length one, rounded.
struct RoundedPlane {
    VectorOf<double> n;
    double h = 0;
};

struct Candidate : HalfSpace {
    RoundedPlane rounded;
};

// The plane inside a cube of that half width.
template <class Real>
Polygon<Real> begin_polygon(const VectorOf<Real>& n, const Real& h, const Real& width) {
    using std::abs;
    std::size_t k = 0;
    for (std::size_t a = 1; a < 3; ++a)
        if (abs(n[a]) > abs(n[k])) k = a;
    const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
    Polygon<Real> polygon;
    for (const auto& [at_u, at_v] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}}) {
        VectorOf<Real> corner;
        corner[u] = at_u * width;
        corner[v] = at_v * width;
        corner[k] = (h - n[u] * corner[u] - n[v] * corner[v]) / n[k];
        polygon.push_back(corner);
    }
    return polygon;
}

int sign_of(double x) {
    return x < 0 ? -1 : x > 0 ? 1 : 0;
}
int sign_of(const mpq_class& x) {
    return sgn(x);
}

template <class Real>
void clip_polygon(Polygon<Real>& polygon, const VectorOf<Real>& n, const Real& h) {
    std::vector<Real> s;
    for (const auto& v : polygon) s.push_back(dot(n, v) - h);
    if (std::ranges::none_of(s, [](const Real& x) { return x > 0; })) return;
    Polygon<Real> kept;
    for (std::size_t a = 0; a < polygon.size(); ++a) {
        const std::size_t b = (a + 1) % polygon.size();
        if (s[a] <= 0) kept.push_back(polygon[a]);
        if (sign_of(s[a]) * sign_of(s[b]) >= 0) continue;
        const Real t = s[a] / (s[a] - s[b]);
        VectorOf<Real> v;
        for (std::size_t k = 0; k < 3; ++k) v[k] = polygon[a][k] + t * (polygon[b][k] - polygon[a][k]);
        kept.push_back(std::move(v));
    }
    if (kept.size() < 3) kept.clear();
    polygon = std::move(kept);
}

void multiply(mpq_class& x, long power_of_two) {
    if (power_of_two >= 0)
        mpq_mul_2exp(x.get_mpq_t(), x.get_mpq_t(), static_cast<mp_bitcnt_t>(power_of_two));
    else
        mpq_div_2exp(x.get_mpq_t(), x.get_mpq_t(), static_cast<mp_bitcnt_t>(-power_of_two));
}

// Normals as short as the smallest double are multiplied by a power of two first.
RoundedPlane rounded(const HalfSpace& plane) {
    RationalVector n = plane.n;
    mpq_class h = plane.h;
    const mpq_class square = dot(n, n);
    const auto bits = [](const mpz_class& x) { return static_cast<long>(mpz_sizeinbase(x.get_mpz_t(), 2)); };
    const long power = (bits(square.get_den()) - bits(square.get_num())) / 2;
    for (mpq_class& x : n) multiply(x, power);
    multiply(h, power);
    const double length = std::sqrt(dot(n, n).get_d());
    RoundedPlane out{{}, h.get_d() / length};
    for (std::size_t k = 0; k < 3; ++k) out.n[k] = n[k].get_d() / length;
    return out;
}

// Returns a polygon that holds the face in a plane: clips in floating point by half-spaces that are moved outward by
// more than all rounding. It is empty for most planes.
Polygon<double> around_face(const std::vector<Candidate>& all, const Candidate& plane, double cube, double outward) {
    Polygon<double> polygon = begin_polygon(plane.rounded.n, plane.rounded.h, cube);
    for (const Candidate& other : all) {
        if (&other != &plane) clip_polygon(polygon, other.rounded.n, other.rounded.h + outward);
        if (polygon.empty()) break;
    }
    return polygon;
}

// Whether a plane surely leaves what others leave of such a polygon as it is.
bool surely_inside(const Polygon<double>& around, const RoundedPlane& plane, double rounding) {
    return std::ranges::all_of(around, [&](const auto& x) { return plane.h - dot(plane.n, x) > rounding; });
}

// The same plane, seen from the same side.
bool coincide(const Candidate& a, const Candidate& b) {
    if (dot(a.rounded.n, b.rounded.n) < 0.9) return false;
    return is_zero(cross(a.n, b.n)) && a.h * dot(b.n, b.n) == b.h * dot(a.n, b.n);
}

// Which of two half-spaces with one plane has no face.
bool is_hidden(const Candidate& s, const Candidate& by) {
    if (by.bisector() != s.bisector()) return s.bisector();
    if (!s.bisector()) return by.face.id > s.face.id;
    const int longer = cmp(dot(by.n, by.n), dot(s.n, s.n));
    return longer > 0 || (longer == 0 && &by < &s);
}

// Returns the relative error of volumes: in single precision 1e-5, else this.
double promise(const votess::Tessellation& t, double in_double) {
    return t.stats().precision == votess::Precision::single ? 1e-5 : in_double;
}

}  // namespace

ExactFace face_of(const votess::Tessellation& t, std::size_t i, std::size_t k) {
    ExactFace face{t.neighbors(i)[k], {}};
    if (!t.shifts().empty())
        std::copy_n(t.shifts().data() + 3 * (static_cast<std::size_t>(t.indptr()[i]) + k), 3, face.shift.begin());
    return face;
}

void clip(std::vector<RationalVector>& polygon, const RationalVector& n, const mpq_class& h) {
    clip_polygon(polygon, n, h);
}

RationalVector doubled_area(const std::vector<RationalVector>& polygon) {
    RationalVector area;
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
        const RationalVector part = cross(minus(polygon[k], polygon[0]), minus(polygon[k + 1], polygon[0]));
        for (std::size_t x = 0; x < 3; ++x) area[x] += part[x];
    }
    return area;
}

std::vector<HalfSpace> half_spaces(std::span<const double> points, const votess::Options& options, std::size_t i,
                                   std::optional<int> reach) {
    const IntegerDomain domain(points, options);
    const std::array<bool, 3>& periodic = options.cell ? options.cell->periodic : options.periodic;
    std::array<int, 3> range{};
    for (std::size_t k = 0; k < 3; ++k) range[k] = periodic[k] ? reach.value_or(0) : 0;
    std::vector<std::array<int, 3>> in_reach;
    for (int a = -range[0]; a <= range[0]; ++a)
        for (int b = -range[1]; b <= range[1]; ++b)
            for (int c = -range[2]; c <= range[2]; ++c) in_reach.push_back({a, b, c});

    std::vector<HalfSpace> all;
    // factor: 2 to this power is the length of the integers' normal, over that wanted.
    const auto add = [&](const IntegerPlane& plane, int factor) {
        HalfSpace s{plane.face, {plane.n[0], plane.n[1], plane.n[2]}, plane.h};
        for (mpq_class& x : s.n) multiply(x, -factor);
        multiply(s.h, domain.quantum() - factor);
        all.push_back(std::move(s));
    };
    for (std::size_t j = 0; j < domain.size(); ++j) {
        if (domain.is_outside(j)) continue;
        for (const auto& shift : reach ? in_reach : domain.near_shifts(i, j))
            if (j != i || shift != std::array<int, 3>{}) add(domain.bisector(i, j, shift), 1 - domain.quantum());
    }
    for (const IntegerPlane& wall : domain.walls(i)) add(wall, 0);
    return all;
}

std::vector<ExactPolygon> polytope(std::vector<HalfSpace> given, double width) {
    // A seed at the same place leaves all or nothing.
    if (std::ranges::any_of(given, [](const HalfSpace& s) { return is_zero(s.n) && s.h < 0; })) return {};
    std::vector<Candidate> all;
    for (HalfSpace& s : given) {
        if (is_zero(s.n)) continue;
        const RoundedPlane plane = rounded(s);
        all.push_back({std::move(s), plane});
    }
    std::ranges::sort(all, {}, [](const Candidate& s) { return s.rounded.h; });
    const double cube = std::ldexp(1.0, std::ilogb(width) + 12), outward = 1e-7 * width;
    std::vector<ExactPolygon> polygons;
    for (const Candidate& s : all) {
        const Polygon<double> around = around_face(all, s, cube, outward);
        if (around.empty()) continue;
        if (std::ranges::any_of(all,
                                [&](const Candidate& by) { return &by != &s && coincide(s, by) && is_hidden(s, by); }))
            continue;
        Polygon<mpq_class> polygon = begin_polygon(s.n, s.h, mpq_class(cube));
        for (const Candidate& other : all) {
            if (polygon.empty()) break;
            if (&other != &s && !surely_inside(around, other.rounded, 0.1 * outward))
                clip_polygon(polygon, other.n, other.h);
        }
        if (polygon.empty()) continue;
        if (dot(doubled_area(polygon), s.n) < 0) std::ranges::reverse(polygon);
        polygons.push_back({s, std::move(polygon)});
    }
    std::ranges::sort(polygons, {}, &ExactPolygon::face);
    if (polygons.size() < 4) return {};
    return polygons;
}

std::vector<ExactPolygon> exact_polygons(std::span<const double> points, const votess::Options& options, std::size_t i,
                                         std::optional<int> reach) {
    std::vector<HalfSpace> all = half_spaces(points, options, i, reach);
    double width = 1;
    // Walls and the images of the seed itself bound the cell; bisectors of weighted seeds may lie at any distance.
    for (const HalfSpace& s : all)
        if (!s.bisector() || s.face.id == static_cast<std::int32_t>(i)) width = std::max(width, std::abs(rounded(s).h));
    return polytope(std::move(all), width);
}

// Exactly: pyramids of a seed outside of its cell cancel.
mpq_class volume_of(std::span<const ExactPolygon> faces) {
    mpq_class volume;
    for (const ExactPolygon& p : faces) volume += dot(doubled_area(p.corners), p.n) * p.h / dot(p.n, p.n) / 6;
    return volume;
}

ExactDomainCell exact_cell(std::span<const double> points, const votess::Options& options, std::size_t i,
                           std::optional<int> reach) {
    const std::vector<ExactPolygon> polygons = exact_polygons(points, options, i, reach);
    ExactDomainCell cell{{}, volume_of(polygons).get_d()};
    for (const ExactPolygon& p : polygons) cell.faces.push_back(p.face);
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
        for (std::size_t k = 0; k < row.size(); ++k) faces.push_back(face_of(t, i, k));
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
    std::set<std::pair<std::int32_t, ExactFace>> faces;
    for (std::size_t i = 0; i < t.size(); ++i) {
        const auto row = t.neighbors(i);
        const bool gone = t.status()[i] != votess::CellStatus::certified;
        if (gone && (!row.empty() || t.volumes()[i] != 0)) return text("cell ", i, " is not empty");
        for (std::size_t k = 0; k < row.size(); ++k)
            if (!faces.emplace(static_cast<std::int32_t>(i), face_of(t, i, k)).second)
                return text("cell ", i, " lists a face twice");
    }
    for (const auto& [i, face] : faces) {
        const auto& [a, b, c] = face.shift;
        if (face.id >= 0 && !faces.contains({face.id, {i, {-a, -b, -c}}}))
            return text("cell ", i, " lists ", face.id, ", which does not list it back");
    }
    return "";
}

}  // namespace test

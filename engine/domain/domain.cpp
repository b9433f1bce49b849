#include "domain/domain.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"
#include "core/vector3.hpp"
#include "domain/lattice_reach.hpp"
#include "exact/integer/rows.hpp"
#include "exact/quad.hpp"

namespace votess {
namespace {

using Vector = Vector3;
using exact::WideInt;

double length(const Vector& a) {
    return std::sqrt(dot(a, a));
}

// Returns the size of the larger term of each coordinate of x - origin.
Vector sizes_of(const Domain& domain, const Vector& x) {
    Vector size;
    for (std::size_t k = 0; k < 3; ++k) size[k] = std::max(std::abs(x[k]), std::abs(domain.origin[k]));
    return size;
}

// Returns the signed volume of three vectors. The condition may cost nine digits, so double would not do.
double triple_product(const std::array<Vector, 3>& v) {
    exact::Quad sum = 0;
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        sum += v[0][k] * (static_cast<exact::Quad>(v[1][l]) * v[2][m] - static_cast<exact::Quad>(v[1][m]) * v[2][l]);
    }
    return static_cast<double>(sum);
}

constexpr double unit = 0x1p-53;

// Computes the rest of a basis from shift and vector. Vectors are scaled to order one, so that no product leaves the
// range.
void invert(Basis& basis) {
    std::array<int, 3> exponent{};
    std::array<Vector, 3> v{};
    for (int j = 0; j < 3; ++j) {
        const auto [x, y, z] = basis.vector[j];
        const double largest = std::max({std::abs(x), std::abs(y), std::abs(z)});
        if (largest > 0) exponent[j] = std::ilogb(largest);
        for (int k = 0; k < 3; ++k) v[j][k] = std::ldexp(basis.vector[j][k], -exponent[j]);
    }
    const double volume = std::abs(triple_product(v));
    basis.volume = std::ldexp(volume, exponent[0] + exponent[1] + exponent[2]);
    basis.condition = length(v[0]) * length(v[1]) * length(v[2]) / volume;
    for (int j = 0; j < 3; ++j) {
        const Vector across = cross(v[(j + 1) % 3], v[(j + 2) % 3]);
        const double along = dot(v[j], across);
        for (int k = 0; k < 3; ++k) basis.dual[j][k] = std::ldexp(across[k] / along, -exponent[j]);
        basis.width[j] = std::ldexp(volume / length(across), exponent[j]);
    }
}

// A quarter of the range leaves room for sums. Numbers that double does not hold exactly are too large as well.
std::int32_t checked_shift(double number) {
    if (!(std::abs(number) <= exact::max_shift / 4))
        throw Error(ErrorCode::unsupported,
                    "the periodic box is so thin or skewed that cells reach over more than 268 million box vectors: "
                    "give shorter vectors of the same lattice");
    return static_cast<std::int32_t>(number);
}

// Makes edges that are not periodic perpendicular to the lattice. Walls stay, and fewer images are near.
void straighten(const Domain& domain, std::array<Vector, 3>& v) {
    const auto periodic = std::ranges::count(domain.periodic, true);
    for (int j = 0; j < 3; ++j) {
        if (domain.periodic[j] || periodic == 0) continue;
        const int i = (j + 1) % 3, l = (j + 2) % 3;
        Vector onto = periodic == 2 ? cross(v[i], v[l]) : v[domain.periodic[i] ? i : l];
        const int exponent = std::ilogb(std::max({std::abs(onto[0]), std::abs(onto[1]), std::abs(onto[2])}));
        for (double& x : onto) x = std::ldexp(x, -exponent);  // its square may underflow
        const double part = dot(v[j], onto) / dot(onto, onto);
        for (int k = 0; k < 3; ++k) v[j][k] = periodic == 2 ? part * onto[k] : v[j][k] - part * onto[k];
    }
}

// Shortens the vectors of a lattice by pairwise reduction. Only speed depends on their length.
Basis reduced_basis(const Domain& domain) {
    Basis basis = domain.edges;
    auto& shifts = basis.shift;
    auto& v = basis.vector;
    constexpr int max_rounds = 100;
    bool shorter = domain.triclinic;
    for (int round = 0; round < max_rounds && shorter; ++round) {
        shorter = false;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                if (i == j || !domain.periodic[i] || !domain.periodic[j]) continue;
                const double multiple = std::round(dot(v[i], v[j]) / dot(v[j], v[j]));
                if (!(std::abs(multiple) >= 1)) continue;
                exact::Shift shift;
                for (int k = 0; k < 3; ++k) shift[k] = checked_shift(shifts[i][k] - multiple * shifts[j][k]);
                const Vector reduced = domain.translation(shift);
                if (!(dot(reduced, reduced) < dot(v[i], v[i]) * (1 - 1e-9))) continue;
                v[i] = reduced;
                shifts[i] = shift;
                shorter = true;
            }
    }
    if (domain.triclinic) straighten(domain, v);
    invert(basis);
    return basis;
}

// edges: of the box. lattice and vector must be set.
void set_edges(Domain& domain, const std::array<Vector, 3>& edges) {
    domain.edges.vector = edges;
    for (int j = 0; j < 3; ++j)
        if (domain.periodic[j]) domain.edges.shift[j][j] = 1;
    invert(domain.edges);
    domain.reduced = reduced_basis(domain);
    for (std::size_t j = 0; j < 3; ++j) {
        if (!domain.periodic[j]) continue;
        const auto d = exact::differences({}, exact::Plane::bisector({}, domain.reduced.shift[j], domain.lattice));
        for (std::size_t k = 0; k < 3; ++k) domain.reduced.low[j][k] = d.x[k].low;
    }
    domain.volume = domain.edges.volume;
    const auto narrowest = [](const Basis& basis) { return std::ranges::min(basis.width); };
    domain.skewed = narrowest(domain.edges) < 0.5 * narrowest(domain.reduced);
    // A point is within half of each short vector of a corner of their parallelepiped. Along other axes it is in the
    // box.
    domain.covering_radius = 0;
    for (int j = 0; j < 3; ++j)
        domain.covering_radius += (domain.periodic[j] ? 0.5 : 1) * length(domain.reduced.vector[j]);
}

exact::Shift in_lattice(const Basis& basis, const std::array<std::int32_t, 3>& multiples) {
    exact::Shift shift;
    for (int k = 0; k < 3; ++k) {
        double sum = 0;
        for (int j = 0; j < 3; ++j) sum += static_cast<double>(multiples[j]) * basis.shift[j][k];
        shift[k] = checked_shift(sum);
    }
    return shift;
}

// Returns the sign of the fraction of x + shift along vector j, minus `less`. W limbs hold the coordinates.
template <int W>
int fraction_sign(const Domain& domain, const exact::Point& x, const exact::Shift& shift, int j, int less,
                  int quantum) {
    using exact::to_wide;
    using Wide = std::array<WideInt<W>, 3>;
    const auto vector = [&](int i) {
        Wide v;
        for (int k = 0; k < 3; ++k) {
            const auto& length = domain.lattice.vector[i][k];
            v[k] = to_wide<W>(length.high, quantum) + to_wide<W>(length.low, quantum);
        }
        return v;
    };
    Wide d;
    for (int k = 0; k < 3; ++k) d[k] = to_wide<W>(x[k], quantum) - to_wide<W>(domain.origin[k], quantum);
    for (int i = 0; i < 3; ++i) {
        const int times = shift[i] - (i == j ? less : 0);
        if (times == 0) continue;
        const Wide v = vector(i);
        for (int k = 0; k < 3; ++k) d[k] = d[k] + exact::resize<W>(v[k] * exact::from_int128<1>(times));
    }
    if (!domain.triclinic) return d[j].sign();
    const auto across = cross(vector((j + 1) % 3), vector((j + 2) % 3));
    return dot(d, across).sign() * dot(vector(j), across).sign();
}

int fraction_sign(const Domain& domain, const exact::Point& x, const exact::Shift& shift, int j, int less) {
    exact::BitRange range;
    range.add(x);
    range.add(domain.origin);
    for (int i = 0; i < 3; ++i) {
        exact::Plane image = exact::Plane::bisector(x);
        image.shift = shift;
        ++image.shift[i];
        image.lattice = &domain.lattice;
        range.add_image(image);
    }
    const int q = range.quantum();
    return range.span() <= 124 ? fraction_sign<2>(domain, x, shift, j, less, q)
                               : fraction_sign<exact::widest>(domain, x, shift, j, less, q);
}

}  // namespace

double largest_coordinate(const Box& box) {
    double largest = 0;
    for (int k = 0; k < 3; ++k) largest = std::max({largest, std::abs(box.lower[k]), std::abs(box.upper[k])});
    return largest;
}

double scale_for(double largest) {
    const int exponent = largest == 0 ? 0 : std::ilogb(largest);
    if (std::abs(exponent) < 64) return 1;
    // 2^1023 is the largest power. A subnormal box of 2^-1074 becomes 2^-51, which is near enough.
    return std::ldexp(1.0, std::clamp(-exponent, -1021, 1023));
}

void sort_walls(Domain& domain) {
    constexpr std::size_t few_walls = 32;
    if (domain.walls.size() <= few_walls) return;
    exact::Point middle;
    for (std::size_t k = 0; k < 3; ++k) middle[k] = 0.5 * domain.box.lower[k] + 0.5 * domain.box.upper[k];
    domain.wall_tree = WallTree(domain.walls, middle);
}

std::array<double, 3> Basis::fraction(const std::array<double, 3>& x) const {
    return {dot(dual[0], x), dot(dual[1], x), dot(dual[2], x)};
}

// x and x - origin err by 2 u size, products and sums by 4 u, and dual by 12 u condition of its length, which the cross
// products and the determinant lose. x - origin is at most 2 size.
double Basis::fraction_error(int j, double size) const {
    return 40 * unit * condition * size * (std::abs(dual[j][0]) + std::abs(dual[j][1]) + std::abs(dual[j][2]));
}

// In a periodic domain the square of the covering radius R is enough. A vertex at distance r that the cell must lose
// lies in the cell of another seed, whose nearest image is within R of it, hence at most r + R away. The reach r +
// sqrt(r^2 + R^2) is longer.
double Domain::max_heavier_by(double weight) const {
    const double more = largest_weight - weight;
    return is_periodic() ? std::min(more, covering_radius * covering_radius * (1 + 1e-6)) : more;
}

exact::Point Domain::translation(const exact::Shift& shift) const {
    const auto d = exact::differences({}, exact::Plane::bisector({}, shift, lattice));
    return {d.x[0].high, d.x[1].high, d.x[2].high};
}

ShiftRange shifts_around(const Domain& domain, const Box& box, const exact::Point& x, double distance) {
    const Basis& basis = domain.reduced;
    Vector size;
    for (int k = 0; k < 3; ++k)
        size[k] = std::max({distance, std::abs(box.lower[k]), std::abs(box.upper[k]), std::abs(x[k])});
    ShiftRange range;
    for (int j = 0; j < 3; ++j) {
        if (!domain.periodic[j]) continue;
        double lower = 0, upper = 0;  // fractions of box - x
        for (int k = 0; k < 3; ++k) {
            const double a = basis.dual[j][k] * (box.lower[k] - x[k]), b = basis.dual[j][k] * (box.upper[k] - x[k]);
            lower += std::min(a, b);
            upper += std::max(a, b);
        }
        const double around =
            distance / basis.width[j] * (1 + 1e-9) + basis.fraction_error(j, size_for(basis, j, size));
        range.lower[j] = static_cast<std::int32_t>(std::ceil(std::max(-around - upper, -0.25 * exact::max_shift)));
        range.upper[j] = static_cast<std::int32_t>(std::floor(std::min(around - lower, 0.25 * exact::max_shift)));
        if (range.upper[j] < range.lower[j]) return {};
    }
    return range;
}

// Sums of two doubles err by 2^-98 of the terms. The result is rounded once more.
Box images_of(const Domain& domain, const Box& box, const ShiftRange& range, const exact::Point& x) {
    using exact::DoubleDouble;
    Box images;
    for (std::size_t k = 0; k < 3; ++k) {
        DoubleDouble lower = exact::two_sum(box.lower[k], -x[k]), upper = exact::two_sum(box.upper[k], -x[k]);
        double steps = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            const DoubleDouble v{domain.reduced.vector[j][k], domain.reduced.low[j][k]};
            if (v.high == 0 || (range.lower[j] == 0 && range.upper[j] == 0)) continue;
            const DoubleDouble least = v * DoubleDouble{static_cast<double>(range.lower[j])};
            const DoubleDouble most =
                range.upper[j] == range.lower[j] ? least : v * DoubleDouble{static_cast<double>(range.upper[j])};
            lower = lower + (v.high > 0 ? least : most);
            upper = upper + (v.high > 0 ? most : least);
            steps += std::max(std::abs(least.high), std::abs(most.high));
        }
        const double lost = steps == 0 ? 0 : 0x1p-98 * (steps + std::abs(x[k])) + 0x1p-1000;
        images.lower[k] = lower.high - (2 * unit * std::abs(lower.high) + lost);
        images.upper[k] = upper.high + (2 * unit * std::abs(upper.high) + lost);
    }
    return images;
}

std::array<ShiftRange, 2> halves(const ShiftRange& range, int axis) {
    const auto j = static_cast<std::size_t>(axis);
    std::array<ShiftRange, 2> parts{range, range};
    parts[0].upper[j] = range.lower[j] + (range.upper[j] - range.lower[j]) / 2;
    parts[1].lower[j] = parts[0].upper[j] + 1;
    return parts;
}

Extent longest_extent(const Domain& domain, const ShiftRange& range) {
    Extent longest;
    for (int j = 0; j < 3; ++j) {
        const double steps = static_cast<double>(range.upper[j]) - range.lower[j];
        const double extent = steps * length(domain.reduced.vector[j]);
        if (extent > longest.length) longest = {j, extent};
    }
    return longest;
}

exact::Shift only_shift(const Domain& domain, const ShiftRange& range) {
    return in_lattice(domain.reduced, range.lower);
}

std::vector<exact::Shift> near_translations(const Domain& domain) {
    constexpr int most = 2;
    std::array<int, 3> steps;
    for (std::size_t j = 0; j < 3; ++j) steps[j] = domain.periodic[j] ? most : 0;
    std::vector<std::pair<double, exact::Shift>> found;
    for (int a = -steps[0]; a <= steps[0]; ++a)
        for (int b = -steps[1]; b <= steps[1]; ++b)
            for (int c = -steps[2]; c <= steps[2]; ++c) {
                if (a == 0 && b == 0 && c == 0) continue;
                const exact::Shift shift = in_lattice(domain.reduced, {a, b, c});
                const Vector by = domain.translation(shift);
                found.emplace_back(dot(by, by), shift);
            }
    std::ranges::sort(found);
    std::vector<exact::Shift> shifts;
    for (const auto& [square, shift] : found) shifts.push_back(shift);
    return shifts;
}

double nearest_translation(const Domain& domain) {
    const auto shifts = near_translations(domain);
    if (shifts.empty()) return std::numeric_limits<double>::infinity();
    return length(domain.translation(shifts.front())) * (1 - 1e-12);
}

Domain box_domain(const Box& box, const std::array<bool, 3>& periodic) {
    Domain domain;
    domain.box = box;
    domain.periodic = periodic;
    domain.origin = box.lower;
    std::array<Vector, 3> vectors{};
    for (int k = 0; k < 3; ++k) {
        vectors[k][k] = box.upper[k] - box.lower[k];
        if (!periodic[k]) continue;
        domain.lattice.vector[k][k] = exact::two_sum(box.upper[k], -box.lower[k]);
        domain.vector[k] = vectors[k];
    }
    set_edges(domain, vectors);
    return domain;
}

Domain triclinic_domain(const TriclinicBox& cell) {
    Domain domain;
    domain.triclinic = true;
    domain.periodic = cell.periodic;
    domain.origin = cell.origin;
    domain.vector = {cell.a, cell.b, cell.c};
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) domain.lattice.vector[j][k] = {domain.vector[j][k], 0};
    constexpr double worst_condition = 1e9, min_volume = 0x1p-900;
    domain.edges.vector = domain.vector;
    invert(domain.edges);
    if (!(domain.edges.condition < worst_condition))
        refuse(
            "cell: its three vectors lie in one plane, or so nearly that its volume is lost: give three "
            "independent vectors");
    if (!(domain.edges.volume > min_volume))
        refuse(
            "cell: its vectors are too short compared with its largest number: move its origin towards 0, or "
            "give vectors of similar length");
    domain.handedness = dot(cell.a, cross(cell.b, cell.c)) < 0 ? -1 : 1;
    if (domain.has_cell_walls()) {
        exact::BitRange range;
        for (const Vector& v : domain.vector) range.add(v);
        // Above it no product of two numbers underflows, and its rounding error does not either: it is no lower than
        // 2^-1000.
        constexpr int lowest_bit = -500;
        if (range.low < lowest_bit)
            refuse(
                "cell: its vectors hold numbers that are too small compared with the largest for exact walls: "
                "set them to 0");
        exact::set_across(domain.lattice);
    }
    for (int k = 0; k < 3; ++k) {
        domain.box.lower[k] = domain.box.upper[k] = cell.origin[k];
        for (const Vector& v : domain.vector) (v[k] < 0 ? domain.box.lower[k] : domain.box.upper[k]) += v[k];
    }
    set_edges(domain, domain.vector);
    return domain;
}

exact::Plane Domain::box_wall(int wall) const {
    const int axis = wall / 2;
    const bool upper = wall % 2 == 1;
    if (triclinic) return exact::Plane::cell_wall(axis, upper, origin, lattice, handedness);
    return upper ? exact::Plane::upper(axis, box.upper[axis]) : exact::Plane::lower(axis, box.lower[axis]);
}

bool inside_walls(const Domain& domain, const exact::Point& x) {
    const Vector f = domain.fraction(x), size = sizes_of(domain, x);
    for (int j = 0; j < 3; ++j) {
        if (domain.periodic[j]) continue;
        const double error = domain.edges.fraction_error(j, size_for(domain.edges, j, size));
        if (f[j] > error && f[j] < 1 - error) continue;
        if (f[j] < -error || f[j] > 1 + error) return false;
        if (fraction_sign(domain, x, {}, j, 0) < 0 || fraction_sign(domain, x, {}, j, 1) > 0) return false;
    }
    return true;
}

std::optional<exact::Shift> wrap(const Domain& domain, const exact::Point& x) {
    exact::Shift shift{};
    const Vector f = domain.fraction(x), size = sizes_of(domain, x);
    for (int j = 0; j < 3; ++j) {
        if (!domain.periodic[j]) continue;
        const double whole = std::floor(f[j]);
        if (!(std::abs(whole) < 0.5 * exact::max_shift)) return std::nullopt;
        shift[j] = -static_cast<std::int32_t>(whole);
    }
    // Rounding of f matters near faces only. One fraction does not depend on the shifts along the others.
    for (int j = 0; j < 3; ++j) {
        if (!domain.periodic[j]) continue;
        const double rest = f[j] - std::floor(f[j]),
                     error = domain.edges.fraction_error(j, size_for(domain.edges, j, size));
        if (rest > error && rest < 1 - error) continue;
        while (fraction_sign(domain, x, shift, j, 0) < 0) ++shift[j];
        while (fraction_sign(domain, x, shift, j, 1) >= 0) --shift[j];
    }
    return shift;
}

exact::Shift shift_into_reduced(const Domain& domain, const exact::Point& x) {
    const auto f = domain.reduced.fraction({x[0] - domain.origin[0], x[1] - domain.origin[1], x[2] - domain.origin[2]});
    std::array<std::int32_t, 3> whole;
    for (int j = 0; j < 3; ++j) whole[j] = -static_cast<std::int32_t>(std::floor(f[j]));
    return in_lattice(domain.reduced, whole);
}

}  // namespace votess

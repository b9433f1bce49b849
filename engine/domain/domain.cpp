#include "domain/domain.hpp"

#include <algorithm>
#include <cmath>

#include "exact/integer_rows.hpp"

namespace votess {
namespace {

using Vector = std::array<double, 3>;
using exact::WideInt;

Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
double length(const Vector& a) {
    return std::sqrt(dot(a, a));
}

struct Inverse {
    std::array<Vector, 3> rows;
    std::array<double, 3> width;  // between opposite faces
    double volume;
    double share;  // the volume, of that of a box with edges as long
};

// Each vector is brought to order one meanwhile, so that no product leaves the range.
Inverse invert(const std::array<Vector, 3>& vectors) {
    std::array<int, 3> exponent{};
    std::array<Vector, 3> v{};
    for (int j = 0; j < 3; ++j) {
        const auto [x, y, z] = vectors[j];
        const double largest = std::max({std::abs(x), std::abs(y), std::abs(z)});
        if (largest > 0) exponent[j] = std::ilogb(largest);
        for (int k = 0; k < 3; ++k) v[j][k] = std::ldexp(vectors[j][k], -exponent[j]);
    }
    Inverse inverse{};
    const double volume = std::abs(dot(v[0], cross(v[1], v[2])));
    inverse.volume = std::ldexp(volume, exponent[0] + exponent[1] + exponent[2]);
    inverse.share = volume / (length(v[0]) * length(v[1]) * length(v[2]));
    for (int j = 0; j < 3; ++j) {
        const Vector across = cross(v[(j + 1) % 3], v[(j + 2) % 3]);
        const double along = dot(v[j], across);
        for (int k = 0; k < 3; ++k) inverse.rows[j][k] = std::ldexp(across[k] / along, -exponent[j]);
        inverse.width[j] = std::ldexp(volume / length(across), exponent[j]);
    }
    return inverse;
}

// Makes the vectors of a lattice short: takes from each the multiples of the others that bring it nearest to 0
// (pairwise reduction), until none becomes shorter. Only speed depends on how short they are. vectors: of the lattice,
// along other axes those of the box.
void find_short_vectors(Domain& domain, const std::array<Vector, 3>& vectors) {
    auto& shifts = domain.short_vectors;
    std::array<Vector, 3> v = vectors;
    for (int j = 0; j < 3; ++j) {
        shifts[j] = {};
        if (domain.periodic[j]) shifts[j][j] = 1;
    }
    constexpr int most_rounds = 100;
    bool shorter = domain.triclinic;
    for (int round = 0; round < most_rounds && shorter; ++round) {
        shorter = false;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                if (i == j) continue;
                const double times = std::round(dot(v[i], v[j]) / dot(v[j], v[j]));
                if (!(std::abs(times) >= 1 && std::abs(times) < 1e6)) continue;
                Vector reduced;
                for (int k = 0; k < 3; ++k) reduced[k] = v[i][k] - times * v[j][k];
                if (!(dot(reduced, reduced) < dot(v[i], v[i]) * (1 - 1e-9))) continue;
                v[i] = reduced;
                for (int k = 0; k < 3; ++k) shifts[i][k] -= static_cast<std::int32_t>(times) * shifts[j][k];
                shorter = true;
            }
    }
    // A point is within half of each short vector of a corner of its parallelepiped, and in the box along other axes.
    domain.covering_radius = 0;
    for (int j = 0; j < 3; ++j) domain.covering_radius += (domain.periodic[j] ? 0.5 : 1) * length(v[j]);
    const Inverse inverse = invert(v);
    domain.to_short = inverse.rows;
    domain.short_width = inverse.width;
    for (int j = 0; j < 3; ++j)
        for (const Vector& edge : vectors) {
            const double k = dot(inverse.rows[j], edge);
            (k < 0 ? domain.short_lower[j] : domain.short_upper[j]) += k;
        }
}

void set_vectors(Domain& domain, const std::array<Vector, 3>& vectors) {
    const Inverse inverse = invert(vectors);
    domain.to_fraction = inverse.rows;
    domain.width = inverse.width;
    domain.volume = inverse.volume;
    find_short_vectors(domain, vectors);
}

// Sign of the fraction of x + shift along vector j, less `less`; W limbs hold the coordinates.
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
    const auto across = exact::cross(vector((j + 1) % 3), vector((j + 2) % 3));
    return exact::dot(d, across).sign() * exact::dot(vector(j), across).sign();
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

std::array<double, 3> Domain::fraction(const exact::Point& x) const {
    const Vector d{x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]};
    return {dot(to_fraction[0], d), dot(to_fraction[1], d), dot(to_fraction[2], d)};
}

exact::Point Domain::translation(const exact::Shift& shift) const {
    exact::Point t{};
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) t[k] += shift[j] * vector[j][k];
    return t;
}

std::vector<exact::Shift> Domain::shifts_within(const exact::Point& x, double distance) const {
    constexpr double slack = 1e-9;
    const Vector d{x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]};
    std::array<int, 3> least{}, most{};
    for (int j = 0; j < 3; ++j) {
        if (!periodic[j]) continue;
        const double at = dot(to_short[j], d), around = distance / short_width[j] + slack;
        least[j] = static_cast<int>(std::ceil(at - around - short_upper[j]));
        most[j] = static_cast<int>(std::floor(at + around - short_lower[j]));
    }
    struct Near {
        double distance;
        exact::Shift shift;
    };
    std::vector<Near> near;
    for (int a = least[0]; a <= most[0]; ++a)
        for (int b = least[1]; b <= most[1]; ++b)
            for (int c = least[2]; c <= most[2]; ++c) {
                exact::Shift shift;
                for (int j = 0; j < 3; ++j)
                    shift[j] = a * short_vectors[0][j] + b * short_vectors[1][j] + c * short_vectors[2][j];
                const exact::Point by = translation(shift);
                double square = 0;
                for (int k = 0; k < 3; ++k) {
                    const double gap = std::max({0.0, box.lower[k] + by[k] - x[k], x[k] - box.upper[k] - by[k]});
                    square += gap * gap;
                }
                if (square <= distance * distance * (1 + slack)) near.push_back({square, shift});
            }
    std::ranges::stable_sort(near, {}, &Near::distance);
    std::vector<exact::Shift> shifts;
    shifts.reserve(near.size());
    for (const Near& n : near) shifts.push_back(n.shift);
    return shifts;
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
    set_vectors(domain, vectors);
    return domain;
}

Domain triclinic_domain(const TriclinicBox& cell) {
    Domain domain;
    domain.triclinic = true;
    domain.periodic = {true, true, true};
    domain.origin = cell.origin;
    domain.vector = {cell.a, cell.b, cell.c};
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) domain.lattice.vector[j][k] = {domain.vector[j][k], 0};
    constexpr double least_share = 1e-9, least_volume = 0x1p-900;
    const Inverse inverse = invert(domain.vector);
    if (!(inverse.share > least_share))
        throw Error(ErrorCode::invalid_argument,
                    "cell: the three vectors lie in one plane, or so nearly that the volume is lost: give three "
                    "independent ones");
    if (!(inverse.volume > least_volume))
        throw Error(ErrorCode::invalid_argument,
                    "cell: its vectors are too short beside its largest number: move its origin towards 0, or give "
                    "vectors of like length");
    for (int k = 0; k < 3; ++k) {
        domain.box.lower[k] = domain.box.upper[k] = cell.origin[k];
        for (const Vector& v : domain.vector) (v[k] < 0 ? domain.box.lower[k] : domain.box.upper[k]) += v[k];
    }
    set_vectors(domain, domain.vector);
    return domain;
}

std::optional<exact::Shift> wrap(const Domain& domain, const exact::Point& x) {
    exact::Shift shift{};
    const auto f = domain.fraction(x);
    for (int j = 0; j < 3; ++j) {
        if (!domain.periodic[j]) continue;
        const double whole = std::floor(f[j]);
        if (!(std::abs(whole) < 0.5 * exact::most_shift)) return std::nullopt;
        shift[j] = -static_cast<std::int32_t>(whole);
    }
    // The rounding of f matters near faces only: one fraction does not depend on the shifts along the others.
    constexpr double near_face = 1e-6;
    for (int j = 0; j < 3; ++j) {
        if (!domain.periodic[j]) continue;
        const double rest = f[j] - std::floor(f[j]);
        if (rest > near_face && rest < 1 - near_face && std::abs(f[j]) < 1e6) continue;
        while (fraction_sign(domain, x, shift, j, 0) < 0) ++shift[j];
        while (fraction_sign(domain, x, shift, j, 1) >= 0) --shift[j];
    }
    return shift;
}

}  // namespace votess

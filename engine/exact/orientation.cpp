#include <algorithm>
#include <cmath>

#include "exact/integer/normals.hpp"
#include "exact/predicate.hpp"

namespace votess::exact {
namespace {

Normal<double> rounded_normal(const Point& p, const Plane& plane) {
    if (plane.is_reversed()) {
        const auto [x, y, z] = differences(p, plane).x;
        return {-x.high, -y.high, -z.high};
    }
    if (plane.kind == Plane::Kind::cell_wall) return plane.rounded_normal();
    if (plane.lattice != nullptr) {
        const auto [x, y, z] = image_differences(p, plane).x;
        return {x.high, y.high, z.high};
    }
    if (plane.is_bisector()) return {plane.seed[0] - p[0], plane.seed[1] - p[1], plane.seed[2] - p[2]};
    if (plane.kind == Plane::Kind::wall) return plane.seed;
    Normal<double> n{};
    n[plane.axis] = wall_sign(plane);
    return n;
}

// Returns 0 when uncertain. With P = sum |Na_k| (|Nb_i Nc_j| + |Nb_j Nc_i|) and u = 2^-53, differences (u), products,
// minors and sums err by at most 8 u P. Products that underflow add at most 2^-1073 (1 + sum |Na_k|); the bound is
// larger because subnormal numbers are slow.
int filtered_orientation(const Normal<double>& a, const Normal<double>& b, const Normal<double>& c) {
    const auto& [ax, ay, az] = a;
    const auto& [bx, by, bz] = b;
    const auto& [cx, cy, cz] = c;
    const double yz = by * cz, zy = bz * cy, zx = bz * cx, xz = bx * cz, xy = bx * cy, yx = by * cx;
    const double determinant = ax * (yz - zy) + ay * (zx - xz) + az * (xy - yx);
    const double sx = std::abs(ax), sy = std::abs(ay), sz = std::abs(az), length = sx + sy + sz;
    const double permanent =
        sx * (std::abs(yz) + std::abs(zy)) + sy * (std::abs(zx) + std::abs(xz)) + sz * (std::abs(xy) + std::abs(yx));
    const double bound = 10 * 0x1p-53 * permanent + 0x1p-1000 * (1 + length);
    return std::abs(determinant) > bound ? sign_of(determinant) : 0;
}

}  // namespace

int orientation(const Point& p, const Plane& a, const Plane& b, const Plane& c) {
    const int likely = filtered_orientation(rounded_normal(p, a), rounded_normal(p, b), rounded_normal(p, c));
    if (likely != 0) return likely;

    const std::array planes{&a, &b, &c};
    return decide_on_normals(p, planes, [](auto n) { return cross_of(n[1], n[2]).turn(n[0]); });
}

}  // namespace votess::exact

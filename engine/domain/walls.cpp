// Walls of any direction: a convex polyhedron.
#include <algorithm>
#include <cmath>
#include <limits>

#include "domain/domain.hpp"
#include "exact/integer_rows.hpp"
#include "options.hpp"

namespace votess {
namespace {

using Vector = std::array<double, 3>;

struct HalfSpace {
    Vector n;  // of length one
    double h;
    int far = -1;  // wall of a box so large that a vertex on it means no bound: 0 .. 5, xmin to zmax
};

// Where three planes meet; false when they hardly do.
bool meet(const HalfSpace& a, const HalfSpace& b, const HalfSpace& c, Vector& x) {
    const auto bc = exact::cross(b.n, c.n), ca = exact::cross(c.n, a.n), ab = exact::cross(a.n, b.n);
    const double determinant = exact::dot(a.n, bc);
    if (!(std::abs(determinant) > 1e-9)) return false;
    for (int k = 0; k < 3; ++k) x[k] = (a.h * bc[k] + b.h * ca[k] + c.h * ab[k]) / determinant;
    return true;
}

}  // namespace

exact::Plane domain_wall(const Wall& wall, double scale, const std::string& name) {
    double largest = 0;
    for (const double n : wall.normal) {
        if (!std::isfinite(n))
            throw Error(ErrorCode::invalid_argument,
                        name + ": its normal holds " + number(n) + ", which is not finite");
        largest = std::max(largest, std::abs(n));
    }
    if (!std::isfinite(wall.offset))
        throw Error(ErrorCode::invalid_argument, name + ": its offset " + number(wall.offset) + " is not finite");
    if (largest == 0) throw Error(ErrorCode::invalid_argument, name + ": its normal is 0: give a direction");
    // In two steps, for the power of two itself may be beyond the range.
    const int exponent = -std::ilogb(largest);
    exact::Point normal;
    exact::BitRange range;
    for (int k = 0; k < 3; ++k) {
        normal[k] = std::ldexp(wall.normal[k], exponent);
        range.add(normal[k]);
    }
    const double offset = std::ldexp(wall.offset, exponent) * scale;
    const bool lossless = std::ldexp(offset / scale, -exponent) == wall.offset && std::isfinite(offset);
    if (range.low < -exact::Plane::lowest_normal_bit || !lossless)
        throw Error(ErrorCode::invalid_argument, name +
                                                     ": the components of its normal, or its offset, differ by too "
                                                     "many orders of magnitude to be decided exactly");
    return exact::Plane::any_wall(normal, offset);
}

Box bounds_of(const std::vector<Wall>& walls, const Box& otherwise) {
    constexpr double far = 1e6, slack = 1e-9, margin = 1e-3;
    double size = 0;
    for (int k = 0; k < 3; ++k) size = std::max(size, otherwise.upper[k] - otherwise.lower[k]);
    std::vector<HalfSpace> planes;
    for (const Wall& wall : walls) {
        const auto& n = wall.normal;
        const double length = std::hypot(n[0], n[1], n[2]);
        planes.push_back({{n[0] / length, n[1] / length, n[2] / length}, wall.offset / length});
    }
    for (int k = 0; k < 3; ++k)
        for (const int sign : {-1, 1}) {
            const double at = sign < 0 ? otherwise.lower[k] - far * size : otherwise.upper[k] + far * size;
            HalfSpace plane{{}, sign * at, 2 * k + (sign > 0 ? 1 : 0)};
            plane.n[k] = sign;
            planes.push_back(plane);
        }
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Box bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    std::array<bool, 6> unbounded{};
    for (std::size_t a = 0; a < planes.size(); ++a)
        for (std::size_t b = a + 1; b < planes.size(); ++b)
            for (std::size_t c = b + 1; c < planes.size(); ++c) {
                Vector x;
                if (!meet(planes[a], planes[b], planes[c], x)) continue;
                const double reach = slack * (size + std::abs(x[0]) + std::abs(x[1]) + std::abs(x[2]));
                const bool kept = std::ranges::all_of(
                    planes, [&](const HalfSpace& plane) { return exact::dot(plane.n, x) <= plane.h + reach; });
                if (!kept) continue;
                for (const auto* plane : {&planes[a], &planes[b], &planes[c]})
                    if (plane->far >= 0) unbounded[static_cast<std::size_t>(plane->far)] = true;
                for (int k = 0; k < 3; ++k) {
                    bounds.lower[k] = std::min(bounds.lower[k], x[k]);
                    bounds.upper[k] = std::max(bounds.upper[k], x[k]);
                }
            }
    for (int k = 0; k < 3; ++k) {
        const double room = margin * (bounds.upper[k] - bounds.lower[k]);
        const bool none = !(bounds.lower[k] <= bounds.upper[k]);
        bounds.lower[k] = none || unbounded[2 * k] ? otherwise.lower[k] : bounds.lower[k] - room;
        bounds.upper[k] = none || unbounded[2 * k + 1] ? otherwise.upper[k] : bounds.upper[k] + room;
    }
    return bounds;
}

bool inside(const exact::Plane& wall, const exact::Point& x) {
    double excess = -wall.wall, size = std::abs(wall.wall);
    for (int k = 0; k < 3; ++k) {
        excess += wall.seed[k] * x[k];
        size += std::abs(wall.seed[k] * x[k]);
    }
    if (std::abs(excess) > 8 * 0x1p-53 * size) return excess < 0;
    exact::BitRange range;
    range.add(x);
    range.add(wall);
    const int q = range.quantum();
    if (range.span() <= 124) return exact::wall_row<2>(x, wall, q).s.sign() >= 0;
    return exact::wall_row<exact::widest>(x, wall, q).s.sign() >= 0;
}

}  // namespace votess

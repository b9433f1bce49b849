#include "gpu/domain/walls.hpp"

#include <algorithm>
#include <cmath>

#include "exact/wide_float.hpp"

namespace votess::gpu {
namespace {

using exact::Int128;
using exact::WideFloat;
using Normal = std::array<WideFloat, 3>;

// n.x = height, in the lengths of the domain.
struct WidePlane {
    Normal n;
    WideFloat height;
};

WideFloat dot(const Normal& n, const exact::Point& x) {
    return n[0] * x[0] + n[1] * x[1] + n[2] * x[2];
}

WidePlane wide(const exact::Plane& wall) {
    if (!wall.is_oblique()) {
        const double sign = wall.kind == exact::Plane::Kind::lower_wall ? -1 : 1;
        WidePlane plane{{0, 0, 0}, sign * wall.wall};
        plane.n[static_cast<std::size_t>(wall.axis)] = sign;
        return plane;
    }
    if (wall.kind == exact::Plane::Kind::wall) return {{wall.seed[0], wall.seed[1], wall.seed[2]}, wall.wall};
    const auto axis = static_cast<std::size_t>(wall.axis);
    const auto &u = wall.lattice->vector[(axis + 1) % 3], &v = wall.lattice->vector[(axis + 2) % 3];
    WidePlane plane;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
        plane.n[k] = (WideFloat(u[l].high) * v[m].high - WideFloat(u[m].high) * v[l].high) * wall.wall;
    }
    plane.height = dot(plane.n, wall.seed);
    exact::Point along{};
    if (wall.shift[axis] != 0)
        for (std::size_t k = 0; k < 3; ++k) along[k] = wall.lattice->vector[axis][k].high;
    plane.height += dot(plane.n, along);
    return plane;
}

// Returns the square root to about 2^-200 of it; a is in the range of doubles.
WideFloat root(const WideFloat& a) {
    WideFloat root = std::sqrt(static_cast<double>(a));
    for (int k = 0; k < 2; ++k) root = ldexp(root + a / root, -1);
    return root;
}

// Rounds numbers below 2^126 to nearest.
Int128 nearest(WideFloat x) {
    Int128 sum = 0;
    for (double rounded = static_cast<double>(x); std::abs(rounded) >= 1; rounded = static_cast<double>(x)) {
        const double whole = std::trunc(rounded);
        sum += static_cast<Int128>(whole);
        x -= whole;
    }
    return sum + static_cast<Int128>(std::round(static_cast<double>(x)));
}

constexpr WallPlane no_wall{{}, {}, {0, 0, 0, UNBOUNDED}};

}  // namespace

std::vector<WallPlane> device_walls(const Job& job, const Box& box) {
    const Domain& domain = *job.domain;
    const Units units = Units::for_box(box);
    const int to_units = units.shift - std::ilogb(job.scale);
    exact::Point origin;  // of the device's coordinates, in units
    for (std::size_t k = 0; k < 3; ++k) origin[k] = units.floor_of(box.lower[k]);

    const auto on_device = [&](const exact::Plane& wall) {
        WidePlane plane = wide(wall);
        double largest = 0;
        for (const WideFloat& n : plane.n) largest = std::max(largest, std::abs(static_cast<double>(n)));
        const int exponent = std::ilogb(largest);
        for (WideFloat& n : plane.n) n = ldexp(n, -exponent);
        plane.height = ldexp(plane.height, to_units - exponent);
        const WideFloat length = root(plane.n[0] * plane.n[0] + plane.n[1] * plane.n[1] + plane.n[2] * plane.n[2]);
        const WideFloat offset = (plane.height - dot(plane.n, origin)) / length;
        WallPlane result{};
        for (std::size_t k = 0; k < 3; ++k) {
            const WideFloat n = plane.n[k] / length;
            result.normal[k] = words(static_cast<std::uint64_t>(nearest(ldexp(n, WALL_BITS))));
            result.rough[k] = static_cast<float>(static_cast<double>(n));
        }
        const auto fixed = static_cast<exact::Uint128>(nearest(ldexp(offset, WALL_BITS) + std::ldexp(0.5, WALL_BITS)));
        result.offset[0] = words(static_cast<std::uint64_t>(fixed));
        result.offset[1] = words(static_cast<std::uint64_t>(fixed >> 64));
        result.rough[3] = static_cast<float>(static_cast<double>(offset));
        return result;
    };
    // Returns whether the corner of the domain's box that is farthest out is not beyond the wall.
    const auto cuts_nothing = [&](const exact::Plane& wall) {
        const WidePlane plane = wide(wall);
        exact::Point corner;
        for (std::size_t k = 0; k < 3; ++k)
            corner[k] = static_cast<double>(plane.n[k]) > 0 ? domain.box.upper[k] : domain.box.lower[k];
        return static_cast<double>(plane.height - dot(plane.n, corner)) >= 0;
    };
    std::vector<WallPlane> walls;
    if (!has_device_walls(domain)) return walls;
    for (int wall = 0; wall < 6; ++wall)
        walls.push_back(domain.has_box_wall(wall) ? on_device(domain.box_wall(wall)) : no_wall);
    for (const exact::Plane& wall : domain.walls) walls.push_back(cuts_nothing(wall) ? no_wall : on_device(wall));
    return walls;
}

}  // namespace votess::gpu

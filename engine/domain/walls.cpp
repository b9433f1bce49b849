// Walls of any direction: a convex polyhedron.
#include <algorithm>
#include <cmath>
#include <limits>

#include "cpu/clip/cell.hpp"
#include "domain/domain.hpp"
#include "exact/integer/rows.hpp"
#include "input/options.hpp"

namespace votess {

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
    const double offset = std::ldexp(wall.offset, exponent) * scale;
    bool lossless = std::ldexp(offset / scale, -exponent) == wall.offset && std::isfinite(offset);
    exact::Point normal;
    exact::BitRange range;
    for (int k = 0; k < 3; ++k) {
        normal[k] = std::ldexp(wall.normal[k], exponent);
        lossless &= std::ldexp(normal[k], -exponent) == wall.normal[k];
        range.add(normal[k]);
    }
    if (range.low < -exact::Plane::lowest_normal_bit || !lossless)
        throw Error(ErrorCode::invalid_argument, name +
                                                     ": the components of its normal, or its offset, differ by too "
                                                     "many orders of magnitude to be decided exactly");
    return exact::Plane::any_wall(normal, offset);
}

// The walls cut a box so large that a face left on it means no bound. The polyhedron's planes and corners are decided
// exactly, however thin it is, and the rounding of a corner's place is far less than what the bounds are moved out by.
Box bounds_of(const std::vector<Wall>& walls, const Box& otherwise) {
    constexpr double far = 1e6, margin = 1e-3, rounding = 8 * 0x1p-53;
    // Only so that no square leaves the range.
    const int exponent = std::ilogb(largest_coordinate(otherwise));
    const double scale = std::ldexp(1.0, std::clamp(exponent, -400, 400) - exponent);
    double size = 0;
    for (int k = 0; k < 3; ++k) size = std::max(size, otherwise.upper[k] * scale - otherwise.lower[k] * scale);
    Domain domain;
    exact::Point middle;
    for (int k = 0; k < 3; ++k) {
        const double lower = otherwise.lower[k] * scale, upper = otherwise.upper[k] * scale;
        middle[k] = 0.5 * (lower + upper);
        domain.box.lower[k] = lower - far * size;
        domain.box.upper[k] = upper + far * size;
    }
    for (std::size_t w = 0; w < walls.size(); ++w)
        domain.walls.push_back(domain_wall(walls[w], scale, "wall " + std::to_string(w)));

    cpu::Cell polyhedron;
    polyhedron.start(middle, domain);
    cpu::CellFaces faces;
    if (!polyhedron.empty()) polyhedron.canonical_faces(faces);
    constexpr std::size_t least_faces = 4;
    if (faces.size() < least_faces) return otherwise;  // no room
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Box bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (const std::int32_t slot : faces.corners) {
        const auto [a, b, c] = polyhedron.corner_planes(slot);
        const auto x = exact::vertex_position<double>({}, a->source, b->source, c->source);
        for (int k = 0; k < 3; ++k) {
            bounds.lower[k] = std::min(bounds.lower[k], x[k]);
            bounds.upper[k] = std::max(bounds.upper[k], x[k]);
        }
    }
    std::array<bool, 6> unbounded{};
    for (const std::int32_t p : faces.planes)
        if (const int wall = -1 - polyhedron.planes()[p].id; wall < 6) unbounded[static_cast<std::size_t>(wall)] = true;
    for (int k = 0; k < 3; ++k) {
        const bool open = unbounded[2 * k] || unbounded[2 * k + 1];
        const double room = margin * (open ? size : bounds.upper[k] - bounds.lower[k]) +
                            rounding * (std::abs(bounds.lower[k]) + std::abs(bounds.upper[k]));
        bounds.lower[k] = unbounded[2 * k] ? otherwise.lower[k] : (bounds.lower[k] - room) / scale;
        bounds.upper[k] = unbounded[2 * k + 1] ? otherwise.upper[k] : (bounds.upper[k] + room) / scale;
    }
    return bounds;
}

bool inside(const exact::Plane& wall, const exact::Point& x) {
    double excess = -wall.wall, size = std::abs(wall.wall);
    for (int k = 0; k < 3; ++k) {
        excess += wall.seed[k] * x[k];
        size += std::abs(wall.seed[k] * x[k]);
    }
    constexpr double underflow = 0x1p-1060;  // more than three products may lose
    if (std::abs(excess) > 8 * 0x1p-53 * size + underflow) return excess < 0;
    exact::BitRange range;
    range.add(x);
    range.add(wall);
    const int q = range.quantum();
    if (range.span() <= 124) return exact::wall_row<2>(x, wall, q).s.sign() >= 0;
    return exact::wall_row<exact::widest>(x, wall, q).s.sign() >= 0;
}

}  // namespace votess

#include "input/default_box.hpp"

#include <algorithm>
#include <cmath>

#include "core/box.hpp"
#include "core/errors.hpp"
#include "core/text.hpp"
#include "polytope/cell.hpp"

namespace votess {

Box default_box(const Box& bounds, std::size_t count, int dimensions) {
    if (count == 0) return {{0, 0, 0}, {1, 1, 1}};
    double longest = 0, largest = 0;
    for (int k = 0; k < 3; ++k) {
        longest = std::max(longest, bounds.upper[k] - bounds.lower[k]);
        largest = std::max({largest, std::abs(bounds.lower[k]), std::abs(bounds.upper[k])});
    }
    const auto number_of_seeds = static_cast<double>(count);
    double margin = 0.5 * longest / (dimensions == 2 ? std::sqrt(number_of_seeds) : std::cbrt(number_of_seeds));
    if (longest == 0) margin = largest == 0 ? 0.5 : 0.5 * largest;
    Box box;
    for (int k = 0; k < 3; ++k) {
        box.lower[k] = std::min(bounds.lower[k] - margin, std::nextafter(bounds.lower[k], -infinity));
        box.upper[k] = std::max(bounds.upper[k] + margin, std::nextafter(bounds.upper[k], infinity));
        if (!std::isfinite(box.lower[k]) || !std::isfinite(box.upper[k]))
            refuse(std::string("the seeds span ") + axis_name[k] + " from " + number(bounds.lower[k]) + " to " +
                   number(bounds.upper[k]) + ", too close to the largest double for a default box: give Options::box");
    }
    return box;
}

// Returns a bound on the error of a coordinate x of a corner.
double corner_error(const cpu::Cell& cell, std::int32_t slot, double x) {
    return cell.tolerance(slot) + 4 * 0x1p-53 * std::abs(x);
}

// The walls clip a box so large that a face on it means no bound. The planes and corners of the polyhedron are exact,
// however thin it is. The bounds move out by far more than the rounding of a corner.
Box bounds_of(const std::vector<Wall>& walls, const Box& otherwise) {
    constexpr double far = 1e6, margin = 1e-3, rounding = 8 * 0x1p-53;
    // Keeps squares in range.
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
    sort_walls(domain);

    cpu::Cell polyhedron;
    polyhedron.start(middle, domain);
    cpu::CellFaces faces;
    if (!polyhedron.empty()) polyhedron.canonical_faces(faces);
    constexpr std::size_t min_faces = 4;
    if (faces.size() < min_faces) return otherwise;  // no room
    Box bounds = empty_box;
    // Only corners that may be outermost are solved exactly.
    Box inner = bounds;
    for (const std::int32_t slot : faces.corners)
        for (int k = 0; k < 3; ++k) {
            const double x = middle[k] + polyhedron.position(slot)[k], error = corner_error(polyhedron, slot, x);
            inner.lower[k] = std::min(inner.lower[k], x + error);
            inner.upper[k] = std::max(inner.upper[k], x - error);
        }
    for (const std::int32_t slot : faces.corners) {
        bool outermost = false;
        for (int k = 0; k < 3; ++k) {
            const double x = middle[k] + polyhedron.position(slot)[k], error = corner_error(polyhedron, slot, x);
            outermost = outermost || !(x - error > inner.lower[k] && x + error < inner.upper[k]);
        }
        if (!outermost) continue;
        const auto [a, b, c] = polyhedron.corner_planes(slot);
        const auto x = exact::vertex_position<double>({}, a->source, b->source, c->source);
        include(bounds, x);
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

}  // namespace votess

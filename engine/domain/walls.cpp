// Walls of any direction, also around round bodies.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/errors.hpp"
#include "core/text.hpp"
#include "core/vector3.hpp"
#include "domain/domain.hpp"
#include "exact/integer/rows.hpp"

namespace votess {
namespace {

using Vector = Vector3;

void check_finite(const char* what, const Vector& x) {
    for (const double c : x)
        if (!std::isfinite(c)) refuse(std::string(what) + " holds " + number(c) + ", which is not finite");
}

void check_radius(double radius) {
    if (!(radius > 0 && std::isfinite(radius))) refuse("the radius " + number(radius) + " is not a positive number");
}

void check_faces(std::size_t faces, std::size_t least) {
    constexpr std::size_t most = 1'000'000;
    if (faces < least || faces > most)
        refuse(std::to_string(faces) + " faces: give " + std::to_string(least) + " to " + std::to_string(most));
}

Vector direction(const char* what, const Vector& x) {
    check_finite(what, x);
    const double largest = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
    if (largest == 0) refuse(std::string(what) + " is 0: give a direction");
    const double scale = std::ldexp(1.0, -std::ilogb(largest));
    const Vector scaled{x[0] * scale, x[1] * scale, x[2] * scale};
    const double length = length3(scaled[0], scaled[1], scaled[2]);
    return {scaled[0] / length, scaled[1] / length, scaled[2] / length};
}

// Returns the plane across n at `distance` along n from `from`.
Wall wall_at(const Vector& from, const Vector& n, double distance) {
    return {n, n[0] * from[0] + n[1] * from[1] + n[2] * from[2] + distance};
}

// Returns `count` directions evenly around the axis, each leaning against it with this sine.
std::vector<Vector> around(const Vector& axis, double sine, std::size_t count) {
    const double cosine = std::sqrt(1 - sine * sine);
    Vector least{};  // the coordinate axis farthest from `axis`
    least[static_cast<std::size_t>(std::ranges::min_element(axis, {}, [](double x) { return std::abs(x); }) -
                                   axis.begin())] = 1;
    const Vector u = direction("axis", cross(axis, least)), v = cross(axis, u);
    std::vector<Vector> all;
    for (std::size_t k = 0; k < count; ++k) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(count);
        Vector n;
        for (std::size_t j = 0; j < 3; ++j)
            n[j] = cosine * (std::cos(angle) * u[j] + std::sin(angle) * v[j]) + sine * axis[j];
        all.push_back(n);
    }
    return all;
}

}  // namespace

exact::Plane domain_wall(const Wall& wall, double scale, const std::string& name) {
    double largest = 0;
    for (const double n : wall.normal) {
        if (!std::isfinite(n)) refuse(name + ": its normal holds " + number(n) + ", which is not finite");
        largest = std::max(largest, std::abs(n));
    }
    if (!std::isfinite(wall.offset)) refuse(name + ": its offset " + number(wall.offset) + " is not finite");
    if (largest == 0) refuse(name + ": its normal is 0: give a direction");
    // Scaled in two steps, because the power of two itself may be out of range.
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
        refuse(name +
               ": the components of its normal, or its offset, differ by too many orders of magnitude to be decided "
               "exactly");
    return exact::Plane::any_wall(normal, offset);
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
    if (range.span() <= 124) return exact::oblique_row<2>(x, wall, q).s.sign() >= 0;
    return exact::oblique_row<exact::widest>(x, wall, q).s.sign() >= 0;
}

// The directions of a Fibonacci lattice (Swinbank and Purser, Q. J. R. Meteorol. Soc. 132, 2006): equal areas, each
// turned by the golden angle.
std::vector<Wall> sphere_walls(const Vector& center, double radius, std::size_t faces) {
    check_finite("center", center);
    check_radius(radius);
    check_faces(faces, 4);
    std::vector<Wall> walls;
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    for (std::size_t k = 0; k < faces; ++k) {
        const double z = 1 - (2 * static_cast<double>(k) + 1) / static_cast<double>(faces), r = std::sqrt(1 - z * z);
        const double angle = golden * static_cast<double>(k);
        walls.push_back(wall_at(center, {r * std::cos(angle), r * std::sin(angle), z}, radius));
    }
    return walls;
}

std::vector<Wall> cylinder_walls(const Vector& point, const Vector& axis, double radius, std::size_t faces) {
    check_finite("point", point);
    check_radius(radius);
    check_faces(faces, 3);
    std::vector<Wall> walls;
    for (const Vector& n : around(direction("axis", axis), 0, faces)) walls.push_back(wall_at(point, n, radius));
    return walls;
}

std::vector<Wall> cone_walls(const Vector& apex, const Vector& axis, double angle, std::size_t faces) {
    check_finite("apex", apex);
    if (!(angle > 0 && angle < std::numbers::pi / 2))
        refuse("the angle " + number(angle) + " is not between 0 and pi/2");
    check_faces(faces, 3);
    std::vector<Wall> walls;
    for (const Vector& n : around(direction("axis", axis), -std::sin(angle), faces))
        walls.push_back(wall_at(apex, n, 0));
    return walls;
}

}  // namespace votess

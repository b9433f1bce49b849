// Walls of any direction: a convex polyhedron.
#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "domain/domain.hpp"
#include "exact/integer/rows.hpp"

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
    // It is scaled in two steps, for the power of two itself may be beyond the range.
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

}  // namespace votess

#include "unbounded/endless_box.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"

namespace votess {
namespace {

constexpr double near_margin = 6;
constexpr std::size_t points_per_check = 4096;

[[noreturn]] void refuse_endless(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, message);
}

// Returns e, where 2^e is the largest power of two that divides x; x is not 0.
int lowest_bit(double x) {
    constexpr int fraction_bits = 52;
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << fraction_bits) - 1);
    const auto exponent = static_cast<int>(bits >> fraction_bits & 0x7ff);
    if (exponent == 0) return std::countr_zero(fraction) - double_bias - fraction_bits + 1;
    return std::countr_zero(fraction | std::uint64_t{1} << fraction_bits) + exponent - double_bias - fraction_bits;
}

struct Spread {
    Box bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    double longest = 0, largest = 0;  // side, absolute coordinate
    int unit = 1024;                  // all coordinates are multiples of 2^unit
    double smallest = 0;              // a coordinate whose lowest bit is the unit

    // Points that are not finite are skipped: the run refuses them.
    explicit Spread(const Points& points) {
        for (std::size_t i = 0; i < points.coordinates(); ++i) {
            if (i % points_per_check == 0) check_stop();
            const double x = points[i];
            if (!std::isfinite(x)) continue;
            bounds.lower[i % 3] = std::min(bounds.lower[i % 3], x);
            bounds.upper[i % 3] = std::max(bounds.upper[i % 3], x);
            if (x == 0) continue;
            if (const int bit = lowest_bit(x); bit < unit) unit = bit, smallest = x;
        }
        for (std::size_t k = 0; k < 3; ++k) {
            if (bounds.lower[k] > bounds.upper[k]) bounds.lower[k] = bounds.upper[k] = 0;
            longest = std::max(longest, bounds.upper[k] - bounds.lower[k]);
            largest = std::max({largest, std::abs(bounds.lower[k]), std::abs(bounds.upper[k])});
        }
    }
};

}  // namespace

EndlessSides::EndlessSides(const std::optional<Box>& box) {
    if (!box) return;
    for (std::size_t k = 0; k < 3; ++k) {
        if (box->lower[k] == -infinity) sides_ |= 1u << 2 * k;
        if (box->upper[k] == infinity) sides_ |= 2u << 2 * k;
    }
}

std::int32_t EndlessSides::id() const {
    return -1 - std::countr_zero(sides_);
}

void check_endless(const Options& options) {
    if (options.periodic[0] || options.periodic[1] || options.periodic[2])
        refuse_endless("Options::box without end and Options::periodic are both given: leave one out");
    if (!options.walls.empty())
        refuse_endless("Options::box without end and Options::walls are both given: walls bound the domain alone");
    if (options.cell) refuse_endless("Options::box and Options::cell are both given: give one of them");
    if (options.min_face > 0 || options.min_area > 0)
        refuse_endless(
            "Options::min_face and Options::min_area need a domain with an end: leave them out, or give Options::box");
}

Box near_box(const Points& points, const Box& box) {
    const Spread spread(points);
    const double margin = spread.longest > 0 ? near_margin * spread.longest : spread.largest > 0 ? spread.largest : 1;
    Box near = box;
    for (std::size_t k = 0; k < 3; ++k) {
        if (box.lower[k] == -infinity) near.lower[k] = std::min(spread.bounds.lower[k], box.upper[k]) - margin;
        if (box.upper[k] == infinity) near.upper[k] = std::max(spread.bounds.upper[k], box.lower[k]) + margin;
    }
    return near;
}

Box far_box(const Points& points, std::span<const double> weights, const Box& box) {
    // How many times the box may be as large as the extent of the points. Weights are scaled by its square, and their
    // lowest bits must not underflow.
    const int max_exponent = weights.empty() ? 700 : 484;
    const Spread spread(points);
    double size = std::max(spread.longest, 0x1p-1000), largest = spread.largest;
    for (std::size_t k = 0; k < 3; ++k)
        for (const double wall : {box.lower[k], box.upper[k]}) {
            if (!std::isfinite(wall)) continue;
            size = std::max({size, std::abs(wall - spread.bounds.lower[k]), std::abs(wall - spread.bounds.upper[k])});
            largest = std::max(largest, std::abs(wall));
        }
    int exponent = std::ilogb(size) + 1, above_vertices = exponent + 4;
    if (spread.smallest != 0) above_vertices += 3 * std::max(exponent - spread.unit, 0);
    if (!weights.empty()) {
        const auto [least, most] = std::ranges::minmax(weights);
        const double difference = most - least;
        if (difference > 0) above_vertices += std::max(std::ilogb(difference) + 2 - 2 * (exponent - 1), 0);
    }
    if (above_vertices - exponent > max_exponent)
        throw Error(ErrorCode::unsupported,
                    "coordinate " + number(spread.smallest) + " is too small beside the extent of the points, " +
                        number(spread.longest) + ", for a domain without end: move it to 0, or give a box");
    if (largest > 0) above_vertices = std::max(above_vertices, std::ilogb(largest) + 3);
    const double far = std::ldexp(1.0, above_vertices);
    Box finite = box;
    for (std::size_t k = 0; k < 3; ++k) {
        if (box.lower[k] == -infinity) finite.lower[k] = -far;
        if (box.upper[k] == infinity) finite.upper[k] = far;
    }
    return finite;
}

}  // namespace votess

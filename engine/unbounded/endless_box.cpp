#include "unbounded/endless_box.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "core/arithmetic.hpp"
#include "core/box.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/vector3.hpp"

namespace votess {
namespace {

constexpr double near_margin = 6;
constexpr std::size_t points_per_check = 4096;

// Returns e, where 2^e is the largest power of two that divides x; x is not 0.
int lowest_bit(double x) {
    constexpr int fraction_bits = 52;
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << fraction_bits) - 1);
    const auto exponent = static_cast<int>(bits >> fraction_bits & 0x7ff);
    if (exponent == 0) return std::countr_zero(fraction) - double_bias - fraction_bits + 1;
    return std::countr_zero(fraction | std::uint64_t{1} << fraction_bits) + exponent - double_bias - fraction_bits;
}

bool is_zero(const Vector3& x) {
    return x == Vector3{};
}

Vector3 direction(const Vector3& x) {
    const double length = length3(x[0], x[1], x[2]);
    return {x[0] / length, x[1] / length, x[2] / length};
}

struct Spread {
    Box bounds = empty_box;  // along the edges
    Box across = empty_box;  // of the parts across the lattice
    double longest = 0;      // side of the latter
    double largest = 0;      // absolute coordinate
    int unit = 1024;         // all coordinates are multiples of 2^unit
    double smallest = 0;     // a coordinate whose lowest bit is the unit

    // Points that are not finite are skipped: the run refuses them.
    Spread(const Points& points, const Edges& edges) {
        for (std::size_t i = 0; i < points.count(); ++i) {
            if (i % points_per_check == 0) check_stop();
            const Vector3 x = point_of(points, i);
            if (!std::ranges::all_of(x, [](double c) { return std::isfinite(c); })) continue;
            const Vector3 part = edges.across(x), place = edges.along(x);
            for (const double c : x) add_number(c);
            include(bounds, place);
            include(across, part);
        }
        for (const double x : edges.numbers()) add_number(x);
        for (std::size_t k = 0; k < 3; ++k) {
            if (bounds.lower[k] > bounds.upper[k]) bounds.lower[k] = bounds.upper[k] = 0;
            if (across.lower[k] <= across.upper[k]) longest = std::max(longest, across.upper[k] - across.lower[k]);
        }
    }
    // Returns a length of the order of the coordinates and of the roots of the weights, for seeds at one place.
    [[nodiscard]] double length(const Weights& weights) const {
        double length = largest;
        for (std::size_t i = 0; i < weights.given.size(); ++i)
            length = std::max(length, std::sqrt(std::abs(weights[i])));
        return length > 0 ? length : 1;
    }

private:
    void add_number(double x) {
        largest = std::max(largest, std::abs(x));
        if (x == 0 || !std::isfinite(x)) return;
        if (const int bit = lowest_bit(x); bit < unit) unit = bit, smallest = x;
    }
};

}  // namespace

std::array<int, 3> endless_axes(const Region& region) {
    std::array<int, 3> axes{-1, -1, -1};
    const EndlessSides sides(region);
    const auto endless = [&](int j) { return sides.has(-1 - 2 * j) || sides.has(-2 - 2 * j); };
    if (!region.cell) {
        for (int j = 0; j < 3; ++j)
            if (endless(j)) axes[static_cast<std::size_t>(j)] = j;
        return axes;
    }
    std::vector<Vector3> given;
    for (int j = 0; j < 3; ++j)
        if (!endless(j)) given.push_back(std::array{region.cell->a, region.cell->b, region.cell->c}[j]);
    const auto largest = [](const Vector3& x) {
        return static_cast<int>(std::ranges::max_element(x, {}, [](double c) { return std::abs(c); }) - x.begin());
    };
    int next = given.size() == 2 ? largest(cross(given[0], given[1])) : given.size() == 1 ? largest(given[0]) + 1 : 0;
    for (int j = 0; j < 3; ++j)
        if (endless(j)) axes[static_cast<std::size_t>(j)] = next++ % 3;
    return axes;
}

void set_ends(Region& region, std::size_t j, int axis, double lower, double upper) {
    const auto k = static_cast<std::size_t>(axis);
    if (!region.cell) {
        region.box->lower[k] = lower, region.box->upper[k] = upper;
        return;
    }
    TriclinicBox& cell = *region.cell;
    cell.origin[k] = lower;
    (j == 0 ? cell.a : j == 1 ? cell.b : cell.c)[k] = upper - lower;
}

Edges::Edges(const Region& region) : region_(region), axes_(endless_axes(region)) {
    const bool cell = region.cell.has_value();
    std::array<Vector3, 3> edge{};
    if (cell) {
        origin_ = region.cell->origin;
        for (const int axis : axes_)
            if (axis >= 0) origin_[static_cast<std::size_t>(axis)] = 0;
        edge = {region.cell->a, region.cell->b, region.cell->c};
    }
    std::vector<Vector3> repeated;
    for (std::size_t j = 0; j < 3; ++j) {
        const bool repeats = region.repeats()[j];
        if (cell) {
            numbers_.insert(numbers_.end(), edge[j].begin(), edge[j].end());
            has_walls_ = has_walls_ || (!repeats && axes_[j] < 0);
        } else if (repeats) {
            numbers_.insert(numbers_.end(), {region.box->lower[j], region.box->upper[j]});
            edge[j][j] = region.box->upper[j] - region.box->lower[j];
        }
        lengths_[j] = length3(edge[j][0], edge[j][1], edge[j][2]);
        longest_sum_ += lengths_[j];
        if (repeats) repeated.push_back(edge[j]);
        if (is_zero(edge[j])) edge[j][axes_[j] < 0 ? j : static_cast<std::size_t>(axes_[j])] = 1;
        edge[j] = direction(edge[j]);
    }
    for (std::size_t j = 0; j < 3; ++j) {
        dual_[j] = cross(edge[(j + 1) % 3], edge[(j + 2) % 3]);
        const double volume = dot(dual_[j], edge[j]);
        for (double& x : dual_[j]) x /= volume;
    }
    for (const Vector3& v : repeated) lattice_.push_back(direction(across(direction(v))));
}

Box Edges::ends_or(const Box& others) const {
    Box ends = others;
    for (std::size_t j = 0; j < 3; ++j) {
        if (region_.box && region_.box->lower[j] != -infinity) ends.lower[j] = region_.box->lower[j];
        if (region_.box && region_.box->upper[j] != infinity) ends.upper[j] = region_.box->upper[j];
        if (region_.cell && axes_[j] < 0) ends.lower[j] = 0, ends.upper[j] = lengths_[j];
    }
    return ends;
}

Region Edges::with_ends(const Box& ends) const {
    Region region = region_;
    if (region.box) region.box = ends_or(ends);
    for (std::size_t j = 0; j < 3; ++j)
        if (region.cell && axes_[j] >= 0) set_ends(region, j, axes_[j], ends.lower[j], ends.upper[j]);
    return region;
}

Vector3 Edges::along(const Vector3& x) const {
    if (!region_.cell) return x;
    const Vector3 from_origin = minus(x, origin_);
    return {dot(dual_[0], from_origin), dot(dual_[1], from_origin), dot(dual_[2], from_origin)};
}

Vector3 Edges::across(Vector3 x) const {
    for (const Vector3& u : lattice_) {
        const double part = dot(u, x);
        for (std::size_t k = 0; k < 3; ++k) x[k] -= part * u[k];
    }
    return x;
}

Box end_near(Region& region, const Points& points, const Weights& weights) {
    const Edges edges(region);
    const Spread spread(points, edges);
    const double longest = std::max(spread.longest, edges.is_periodic() ? edges.longest_sum() : 0);
    // Places along edges are rounded, and ends are.
    const double rounding = (region.cell ? 0x1p-40 : 0x1p-48) * spread.largest;
    const double beyond = longest > 0 ? near_margin * longest : spread.length(weights);
    const double margin = region.cell ? beyond + rounding : std::max(beyond, rounding);
    Box ends = edges.ends_or(all_space);
    for (std::size_t j = 0; j < 3; ++j) {
        const double lower = ends.lower[j], upper = ends.upper[j];
        if (lower == -infinity) ends.lower[j] = std::min(spread.bounds.lower[j], upper) - margin;
        if (upper == infinity) ends.upper[j] = std::max(spread.bounds.upper[j], lower) + margin;
    }
    region = edges.with_ends(ends);
    return ends;
}

Box end_far(Region& region, const Points& points, const Weights& weights) {
    // How many times the box may be as large as the extent of the points. Weights are scaled by its square, and their
    // lowest bits must not underflow. Neither must products of numbers of a cell.
    const int max_exponent = region.cell ? 360 : weights.empty() ? 700 : 484;
    const Edges edges(region);
    const Spread spread(points, edges);
    double size = std::max(spread.longest, 0x1p-1000), largest = spread.largest;
    const bool bisectors = spread.longest > 0 || edges.is_periodic();
    if (!bisectors) size = largest = spread.length(weights);
    for (std::size_t k = 0; region.box && k < 3; ++k)
        for (const double wall : {region.box->lower[k], region.box->upper[k]}) {
            if (!std::isfinite(wall) || region.periodic[k]) continue;
            size = std::max({size, std::abs(wall - spread.bounds.lower[k]), std::abs(wall - spread.bounds.upper[k])});
            largest = std::max(largest, std::abs(wall));
        }
    if (edges.has_walls()) size = std::max(size, 4 * largest);
    // Parts across the lattice are rounded, and no longer than twice their longest coordinate.
    if (region.cell) size = 2 * size + 0x1p-40 * largest;
    size += edges.longest_sum();
    for (std::size_t k = 0; region.cell && k < 3; ++k) largest = std::max(largest, std::abs(region.cell->origin[k]));
    const int exponent = std::ilogb(size) + 1;
    int above_vertices = exponent + (region.cell ? 6 : 4);
    if (bisectors) {
        if (spread.smallest != 0) above_vertices += 3 * std::max(exponent - spread.unit, 0);
        const int without_weights = above_vertices;
        double least = infinity, most = -infinity;
        for (std::size_t i = 0; i < weights.given.size(); ++i)
            least = std::min(least, weights[i]), most = std::max(most, weights[i]);
        const double difference = weights.empty() ? 0 : most - least;
        if (difference > 0) above_vertices += std::max(std::ilogb(difference) + 2 - 2 * (exponent - 1), 0);
        const std::string remedy =
            number(std::max(spread.longest, edges.longest_sum())) + ", for a domain without end: ";
        if (without_weights - exponent > max_exponent)
            throw Error(ErrorCode::unsupported, "coordinate " + number(spread.smallest) +
                                                    " is too small beside the extent of the points, " + remedy +
                                                    "move it to 0, or give a box");
        if (above_vertices - exponent > max_exponent)
            throw Error(ErrorCode::unsupported, "weights that differ by " + number(difference) +
                                                    " are too large beside the extent of the points, " + remedy +
                                                    "give a box");
    }
    if (largest > 0) above_vertices = std::max(above_vertices, std::ilogb(largest) + 3);
    const double far = std::ldexp(1.0, above_vertices);
    const Box ends = edges.ends_or({{-far, -far, -far}, {far, far, far}});
    region = edges.with_ends(ends);
    return ends;
}

}  // namespace votess

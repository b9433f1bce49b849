// Walls around the convex hull of points: planes of its facets, rounded outward.
//
// The normal N of a facet is exact, the normal n of its wall rounded: n = N + e. For a point x and a corner a of the
// facet N.(x - a) <= 0, so n.x <= n.a + sum |e_k| |x_k - a_k|. The offset is that bound with the extents of all points.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "domain/domain.hpp"
#include "domain/hull.hpp"
#include "exact/insphere.hpp"
#include "input/options.hpp"

namespace votess {
namespace {

using exact::Point;

[[noreturn]] void refuse_hull(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, message);
}

void check_no_domain(const Options& options) {
    const auto refuse_if = [](bool given, const char* name) {
        if (given) refuse_hull(std::string("the convex hull and Options::") + name + " are both given: leave one out");
    };
    refuse_if(options.box.has_value(), "box");
    refuse_if(options.cell.has_value(), "cell");
    refuse_if(options.periodic != std::array<bool, 3>{}, "periodic");
    refuse_if(!options.walls.empty(), "walls");
    if (options.outside != Outside::error)
        refuse_hull("no point is outside of the convex hull: leave out Options::outside");
}

// Returns the points times scale, those of the plane with z = 0.
std::vector<Point> scaled_points(std::span<const double> points, double scale, std::size_t dimensions) {
    std::vector<Point> scaled(points.size() / dimensions);
    in_pieces(scaled.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t k = 0; k < dimensions; ++k) {
                const double x = points[dimensions * i + k];
                if (x * scale / scale != x)
                    refuse_hull("point " + std::to_string(i) + ": " + axis_name[k] + " = " + number(x) +
                                " is too small beside the largest coordinate for a hull: move it to 0");
                scaled[i][k] = x * scale;
            }
    });
    return scaled;
}

double next_up(double x) {
    return std::nextafter(x, infinity);
}

// Returns the lowest double that is surely not below normal.x for any point; with an exact normal, the lowest one.
double offset_of(const exact::RoundedNormal& normal, const Point& corner, const Point& extents) {
    constexpr double product_error = 0x1p-100, underflow = 0x1p-1060, inflation = 1 + 0x1p-40;
    exact::DoubleDouble sum;
    double size = 0, slack = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        sum = sum + exact::two_product(normal.n[k], corner[k]);
        size += std::abs(normal.n[k] * corner[k]);
        slack += normal.error[k] * extents[k];
    }
    if (slack == 0 && inside(exact::Plane::any_wall(normal.n, sum.high), corner)) return sum.high;
    const double outward = inflation * (slack + product_error * size + underflow);
    const exact::DoubleDouble end = exact::two_sum(sum.high, sum.low + outward);
    return end.low > 0 ? next_up(end.high) : end.high;
}

}  // namespace

std::vector<Wall> hull_walls(std::span<const double> given, const Options& options) {
    check_no_domain(options);
    Progress progress(options.progress);
    const Stoppable stoppable(progress);
    const std::size_t dimensions = options.planar ? 2 : 3;
    const std::vector<double> copy(given.begin(), given.end());  // read once, see input/snapshot.hpp
    if (copy.size() % dimensions != 0)
        refuse_hull("points hold " + std::to_string(copy.size()) + " coordinates, not a multiple of " +
                    std::to_string(dimensions));
    Point lower{infinity, infinity, infinity}, upper{-infinity, -infinity, -infinity};
    for (std::size_t i = 0; i < copy.size(); ++i) {
        const std::size_t k = i % dimensions;
        if (!std::isfinite(copy[i]))
            refuse_hull("point " + std::to_string(i / dimensions) + ": " + axis_name[k] + " = " + number(copy[i]) +
                        " is not finite");
        lower[k] = std::min(lower[k], copy[i]);
        upper[k] = std::max(upper[k], copy[i]);
    }
    double largest = 0;
    Point extents{};
    for (std::size_t k = 0; k < dimensions && !copy.empty(); ++k)
        largest = std::max({largest, std::abs(lower[k]), std::abs(upper[k])});
    const double scale = scale_for(largest);
    for (std::size_t k = 0; k < dimensions && !copy.empty(); ++k)
        extents[k] = next_up(upper[k] * scale - lower[k] * scale);

    // In the plane an apex over the points makes a pyramid. The triangles at the apex are its sides.
    std::vector<Point> points = scaled_points(copy, scale, dimensions);
    const std::size_t count = points.size();
    const auto apex = static_cast<std::int32_t>(options.planar ? count : -1);
    if (options.planar && count > 0) points.push_back({lower[0] * scale, lower[1] * scale, 1});
    const Hull hull(points);
    if (hull.is_flat())
        refuse_hull(count <= dimensions
                        ? std::to_string(count) + " points have no convex hull with an interior: give at least " +
                              std::to_string(dimensions + 1) + ", or another domain"
                        : std::string("all points lie ") + (options.planar ? "on one line" : "in one plane") +
                              ", so their convex hull has no interior: give another domain");
    std::vector<Wall> walls;
    for (const Hull::Triangle& facet : hull.facets()) {
        std::array<Point, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) corner[k] = points[static_cast<std::size_t>(facet.vertex[k])];
        if (options.planar) {
            const auto at_apex = std::ranges::find(facet.vertex, apex) - facet.vertex.begin();
            if (at_apex == 3) continue;  // the base
            std::ranges::rotate(corner, corner.begin() + at_apex);
            corner[0] = {corner[1][0], corner[1][1], 1};  // makes the side upright
        }
        const exact::RoundedNormal normal = exact::triangle_normal(corner[0], corner[1], corner[2]);
        const double offset = offset_of(normal, corner[1], extents);
        double end = offset / scale;
        if (end * scale < offset) end = next_up(end);
        if (!std::isfinite(end))
            refuse_hull("coordinate " + number(largest) +
                        " is too close to the largest double for a hull: give lengths in a larger unit");
        walls.push_back({normal.n, end});
    }
    return walls;
}

}  // namespace votess

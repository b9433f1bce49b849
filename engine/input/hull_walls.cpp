// Walls around the convex hull of points: planes of its facets, rounded outward.
//
// The normal N of a facet is exact, the normal n of its wall rounded: n = N + e. For a point x and a corner a of the
// facet N.(x - a) <= 0, so n.x <= n.a + sum |e_k| |x_k - a_k|. The offset is that bound with the extents of all points.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "domain/domain.hpp"
#include "domain/hull.hpp"
#include "exact/insphere.hpp"
#include "input/hull_of_parts.hpp"
#include "input/settle.hpp"

namespace votess {
namespace {

using exact::Point;

void check_no_domain(const Region& region) {
    const auto refuse_if = [](bool given, const char* name) {
        if (given) refuse(std::string("the convex hull and Options::") + name + " are both given: leave one out");
    };
    refuse_if(region.box.has_value(), "box");
    refuse_if(region.cell.has_value(), "cell");
    refuse_if(region.periodic != std::array<bool, 3>{}, "periodic");
    refuse_if(!region.walls.empty(), "walls");
    if (region.outside != Outside::error) refuse("no point is outside of the convex hull: leave out Options::outside");
}

double next_up(double x) {
    return std::nextafter(x, infinity);
}

// Points at a scale of order one, those of the plane with z = 0 and an apex at the end. The apex makes a pyramid over
// them. The triangles at it are the sides of their hull.
struct ScaledPoints {
    double largest = 0, scale = 1;
    Point extents{};  // rounded up
    std::vector<Point> points;
    std::int32_t apex = -1;  // -1: none

    // first: number of the first point, for messages.
    ScaledPoints(std::span<const double> given, std::size_t dimensions, std::uint64_t first) {
        Point lower{infinity, infinity, infinity}, upper{-infinity, -infinity, -infinity};
        for (std::size_t i = 0; i < given.size(); ++i) {
            const std::size_t k = i % dimensions;
            if (!std::isfinite(given[i]))
                refuse("point " + std::to_string(first + i / dimensions) + ": " + axis_name[k] + " = " +
                       number(given[i]) + " is not finite");
            lower[k] = std::min(lower[k], given[i]);
            upper[k] = std::max(upper[k], given[i]);
        }
        if (given.empty()) return;
        for (std::size_t k = 0; k < dimensions; ++k)
            largest = std::max({largest, std::abs(lower[k]), std::abs(upper[k])});
        scale = scale_for(largest);
        for (std::size_t k = 0; k < dimensions; ++k) extents[k] = next_up(upper[k] * scale - lower[k] * scale);
        points.resize(given.size() / dimensions);
        in_pieces(points.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                for (std::size_t k = 0; k < dimensions; ++k) {
                    const double x = given[dimensions * i + k];
                    if (x * scale / scale != x)
                        refuse("point " + std::to_string(first + i) + ": " + axis_name[k] + " = " + number(x) +
                               " is too small beside the largest coordinate for a hull: move it to 0");
                    points[i][k] = x * scale;
                }
        });
        if (dimensions == 3) return;
        apex = static_cast<std::int32_t>(points.size());
        const double height = std::ldexp(1, std::ilogb(largest * scale) + 1);  // so that the unit has no influence
        points.push_back({lower[0] * scale, lower[1] * scale, height});
    }
};

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

HullOfParts::HullOfParts(const Region& given) : planar_(given.planar), dimensions_(planar_ ? 2 : 3) {
    check_no_domain(given);
}

void HullOfParts::add(std::span<const double> points) {
    if (points.size() % dimensions_ != 0)
        refuse("points hold " + std::to_string(points.size()) + " coordinates, not a multiple of " +
               std::to_string(dimensions_));
    points_.insert(points_.end(), points.begin(), points.end());
    added_ += points.size() / dimensions_;
    constexpr std::size_t enough = 30000;  // coordinates, so that small parts do not each make a hull
    if (points_.size() - known_ >= std::max(enough, known_)) (void)corners();
}

const std::vector<double>& HullOfParts::corners() {
    if (known_ == points_.size()) return points_;
    const ScaledPoints scaled(points_, dimensions_, added_ - points_.size() / dimensions_);
    const Hull hull(scaled.points);
    known_ = points_.size();
    if (hull.is_flat()) return points_;
    std::vector<Point> corners;
    for (const std::int32_t i : hull.corners())
        if (i != scaled.apex) {
            Point& corner = corners.emplace_back();
            for (std::size_t k = 0; k < dimensions_; ++k)
                corner[k] = points_[dimensions_ * static_cast<std::size_t>(i) + k] + 0.0;  // 0 instead of -0
        }
    std::ranges::sort(corners);
    points_.clear();
    for (const Point& corner : corners)
        points_.insert(points_.end(), corner.begin(), corner.begin() + static_cast<std::ptrdiff_t>(dimensions_));
    known_ = points_.size();
    return points_;
}

std::vector<Wall> HullOfParts::walls(std::uint64_t count) {
    const ScaledPoints scaled(corners(), dimensions_, 0);
    const Hull hull(scaled.points);
    if (hull.is_flat())
        refuse(count <= dimensions_
                   ? std::to_string(count) + " points have no convex hull with an interior: give at least " +
                         std::to_string(dimensions_ + 1) + ", or another domain"
                   : std::string("all points lie ") + (planar_ ? "on one line" : "in one plane") +
                         ", so their convex hull has no interior: give another domain");
    std::vector<Wall> walls;
    for (const Hull::Triangle& facet : hull.facets()) {
        std::array<Point, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) corner[k] = scaled.points[static_cast<std::size_t>(facet.vertex[k])];
        if (planar_) {
            const auto at_apex = std::ranges::find(facet.vertex, scaled.apex) - facet.vertex.begin();
            if (at_apex == 3) continue;  // the base
            std::ranges::rotate(corner, corner.begin() + at_apex);
            corner[0] = {corner[1][0], corner[1][1], 1};  // makes the side upright
        }
        const exact::RoundedNormal normal = exact::triangle_normal(corner[0], corner[1], corner[2]);
        const double offset = offset_of(normal, corner[1], scaled.extents);
        double end = offset / scaled.scale;
        if (end * scaled.scale < offset) end = next_up(end);
        if (!std::isfinite(end))
            refuse("coordinate " + number(scaled.largest) +
                   " is too close to the largest double for a hull: give lengths in a larger unit");
        walls.push_back({normal.n, end});
    }
    return walls;
}

std::vector<Wall> hull_walls(std::span<const double> given, const Options& options) {
    HullOfParts hull(region_of(options));
    Progress progress(options.progress);
    const Stoppable stoppable(progress);
    const std::vector<double> copy(given.begin(), given.end());  // read once, see input/snapshot.hpp
    hull.add(copy);
    return hull.walls(copy.size() / (options.planar ? 2 : 3));
}

}  // namespace votess

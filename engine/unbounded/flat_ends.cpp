#include "unbounded/flat_ends.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "domain/domain.hpp"
#include "exact/insphere.hpp"

namespace votess {
namespace {

using exact::Point;

constexpr double relative_height = 0x1p-3;  // over the mean distance of the seeds
constexpr double least_height = 0x1p-36;    // over the largest coordinate: far above the rounding of a wall
constexpr std::size_t seeds_per_check = 4096;

// The coordinates, brought to order one.
class Scaled {
public:
    explicit Scaled(const Points& points) : points_(points) {
        double largest = 0;
        for (std::size_t i = 0; i < points.coordinates(); ++i) {
            if (i % seeds_per_check == 0) check_stop();
            if (!std::isfinite(points[i])) return;
            largest = std::max(largest, std::abs(points[i]));
        }
        scale_ = scale_for(largest);
        largest_ = largest * scale_;
        exact_ = true;
        for (std::size_t i = 0; i < points.coordinates() && scale_ != 1; ++i)
            exact_ = exact_ && points[i] * scale_ / scale_ == points[i];
    }

    [[nodiscard]] bool exact() const { return exact_; }  // and finite
    [[nodiscard]] double scale() const { return scale_; }
    [[nodiscard]] double largest() const { return largest_; }
    [[nodiscard]] std::size_t size() const { return points_.count(); }
    [[nodiscard]] Point operator[](std::size_t i) const {
        return {points_[3 * i] * scale_, points_[3 * i + 1] * scale_, points_[3 * i + 2] * scale_};
    }
    // Returns the first point from `begin` on that suits, or the size.
    [[nodiscard]] std::size_t first(std::size_t begin, const auto& suits) const {
        while (begin < size() && !suits((*this)[begin])) {
            if (begin % seeds_per_check == 0) check_stop();
            ++begin;
        }
        return begin;
    }

private:
    const Points& points_;
    double scale_ = 1, largest_ = 0;
    bool exact_ = false;
};

}  // namespace

FlatEnds::FlatEnds(const Points& points, const Box& box) {
    const Scaled x(points);
    if (!x.exact() || x.size() < 2) return;
    const Point a = x[0];
    const std::size_t second = x.first(1, [&](const Point& p) { return p != a; });
    if (second == x.size()) return;  // one place
    const Point b = x[second];
    const std::size_t third =
        x.first(second + 1, [&](const Point& p) { return exact::triangle_normal(a, b, p).n != Point{}; });
    std::vector<exact::RoundedNormal> normals;
    if (third < x.size()) {
        const Point c = x[third];
        if (x.first(third + 1, [&](const Point& p) { return exact::orient(a, b, c, p) != 0; }) < x.size()) return;
        normals.push_back(exact::triangle_normal(a, b, c));
    } else {
        const Vector3 along = minus(b, a);
        const auto longest = std::ranges::max_element(along, {}, [](double d) { return std::abs(d); }) - along.begin();
        for (const std::ptrdiff_t k : {(longest + 1) % 3, (longest + 2) % 3}) {
            Point beside = a;
            beside[static_cast<std::size_t>(k)] += 2 * x.largest();
            normals.push_back(exact::triangle_normal(a, b, beside));
        }
    }
    for (const auto& [normal, error] : normals)
        for (std::size_t k = 0; k < 3; ++k) {
            const bool across = normal[k] != 0 || error[k] != 0;
            if (across && (std::isfinite(box.lower[k]) || std::isfinite(box.upper[k]))) return;
        }

    Vector3 lower = a, upper = a;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            lower[k] = std::min(lower[k], x[i][k]);
            upper[k] = std::max(upper[k], x[i][k]);
        }
    Vector3 extent = minus(upper, lower);
    std::ranges::sort(extent, std::greater());
    const auto count = static_cast<double>(x.size());
    const double distance = normals.size() == 1 ? std::sqrt(extent[0] * extent[1] / count) : extent[0] / count;
    const double height = std::max(relative_height * distance, least_height * x.largest());
    for (const auto& [normal, error] : normals) {
        const auto& [nx, ny, nz] = normal;
        const double offset = dot(normal, a), reach = height * length3(nx, ny, nz), unscale = 1 / x.scale();
        if (const auto axis = std::ranges::find_if(normal, [](double n) { return n != 0; });
            std::count(normal.begin(), normal.end(), 0.0) == 2) {
            const auto k = static_cast<std::size_t>(axis - normal.begin());
            thin_[k] = true;
            sides_.lower[k] = (a[k] - height) * unscale;
            sides_.upper[k] = (a[k] + height) * unscale;
            continue;
        }
        walls_.push_back({normal, (offset + reach) * unscale});
        walls_.push_back({{-nx, -ny, -nz}, (reach - offset) * unscale});
    }
}

void FlatEnds::cut(Options& options) const {
    options.walls = walls_;
    for (std::size_t k = 0; k < 3; ++k)
        if (thin_[k]) options.box->lower[k] = sides_.lower[k], options.box->upper[k] = sides_.upper[k];
}

}  // namespace votess

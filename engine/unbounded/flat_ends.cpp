#include "unbounded/flat_ends.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "domain/domain.hpp"
#include "unbounded/endless_box.hpp"

namespace votess {
namespace {

using exact::Point;

constexpr double relative_height = 0x1p-3;  // over the mean distance of the seeds
constexpr double least_height = 0x1p-36;    // over the largest coordinate: far above the rounding of a wall
constexpr double farthest_held = 0x1p8;     // over the same: ends there are rounded by far less than the height
constexpr std::size_t seeds_per_check = 4096;

// The lengths of a lattice along axes, 0 across it; nothing where it lies along others than axes and their planes.
std::optional<Vector3> periods_of(const Region& region) {
    Vector3 periods{};
    std::ptrdiff_t dimensions = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        if (!region.repeats()[j]) continue;
        ++dimensions;
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = region.cell ? std::array{region.cell->a, region.cell->b, region.cell->c}[j][k]
                             : j == k    ? region.box->upper[j] - region.box->lower[j]
                                         : 0;
            periods[k] = std::max(periods[k], std::abs(x));
        }
    }
    if (3 - std::ranges::count(periods, 0.0) != dimensions) return std::nullopt;
    return periods;
}

// The coordinates, brought to order one. Those along a lattice are 0, and the first points are a seed and its images.
class Scaled {
public:
    Scaled(const Points& points, const Vector3& periods) : points_(points), periods_(periods) {
        for (std::size_t k = 0; k < 3; ++k)
            if (periods[k] != 0) along_.push_back(k);
        double largest = 0;
        for (std::size_t i = 0; i < points.coordinates(); ++i) {
            if (i % seeds_per_check == 0) check_stop();
            if (!std::isfinite(points[i])) return;
            largest = std::max(largest, std::abs(points[i]));
        }
        for (const double period : periods) largest = std::max(largest, period);
        scale_ = scale_for(largest);
        largest_ = largest * scale_;
        exact_ = true;
        for (std::size_t i = 0; i < points.coordinates() && scale_ != 1; ++i)
            exact_ = exact_ && points[i] * scale_ / scale_ == points[i];
    }

    [[nodiscard]] bool exact() const { return exact_; }  // and finite
    [[nodiscard]] double scale() const { return scale_; }
    [[nodiscard]] double largest() const { return largest_; }
    [[nodiscard]] std::size_t size() const { return points_.count() == 0 ? 0 : points_.count() + along_.size(); }
    [[nodiscard]] Point operator[](std::size_t i) const {
        const std::size_t image = i >= 1 && i <= along_.size() ? i : 0;
        const std::size_t point = image != 0 ? 0 : i == 0 ? 0 : i - along_.size();
        Point x{points_[3 * point] * scale_, points_[3 * point + 1] * scale_, points_[3 * point + 2] * scale_};
        for (const std::size_t k : along_) x[k] = 0;
        if (image != 0) x[along_[image - 1]] = periods_[along_[image - 1]] * scale_;
        return x;
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
    const Vector3& periods_;
    std::vector<std::size_t> along_;
    double scale_ = 1, largest_ = 0;
    bool exact_ = false;
};

}  // namespace

FlatEnds::FlatEnds(const Points& points, const Region& region) : axes_(endless_axes(region)) {
    const std::optional<Vector3> periods = periods_of(region);
    if (!periods) return;
    const Scaled x(points, *periods);
    if (!x.exact() || x.size() < 2) return;
    const Point a = x[0];
    const std::size_t second = x.first(1, [&](const Point& p) { return p != a; });
    if (second == x.size()) return;  // one place
    const Point b = x[second];
    const std::size_t third =
        x.first(second + 1, [&](const Point& p) { return exact::triangle_normal(a, b, p).n != Point{}; });
    const auto add_plane = [&](const Point& c, const Point& d) {
        planes_.push_back({exact::triangle_normal(a, c, d), {a, c, d}});
    };
    if (third < x.size()) {
        const Point c = x[third];
        if (x.first(third + 1, [&](const Point& p) { return exact::orient(a, b, c, p) != 0; }) < x.size()) return;
        add_plane(b, c);
    } else {
        const Vector3 along = minus(b, a);
        const auto longest = std::ranges::max_element(along, {}, [](double d) { return std::abs(d); }) - along.begin();
        for (const std::ptrdiff_t k : {(longest + 1) % 3, (longest + 2) % 3}) {
            Point beside = a;
            beside[static_cast<std::size_t>(k)] += 2 * x.largest();
            add_plane(b, beside);
        }
    }
    const EndlessSides sides(region);
    const bool periodic = *periods != Vector3{};
    std::erase_if(planes_, [&](const FlatPlane& plane) {
        const auto& [n, error] = plane.normal;
        std::size_t across = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            if (n[k] == 0 && error[k] == 0) continue;
            ++across;
            const int pair = pair_of(static_cast<int>(k));
            if (pair < 0 || !sides.has(-1 - 2 * pair) || !sides.has(-2 - 2 * pair)) return true;
        }
        return across > 1 && periodic;
    });

    scale_ = x.scale();
    farthest_ = farthest_held * x.largest();
    for (std::size_t k = 0; k < 3; ++k) ignored_[k] = (*periods)[k] != 0;

    Vector3 lower = a, upper = a;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            lower[k] = std::min(lower[k], x[i][k]);
            upper[k] = std::max(upper[k], x[i][k]);
        }
    Vector3 extent = minus(upper, lower);
    std::ranges::sort(extent, std::greater());
    const auto count = static_cast<double>(x.size());
    const double distance = third < x.size() ? std::sqrt(extent[0] * extent[1] / count) : extent[0] / count;
    const double height = std::max(relative_height * distance, least_height * x.largest());
    for (const FlatPlane& plane : planes_) {
        const Vector3& normal = plane.normal.n;
        const auto& [nx, ny, nz] = normal;
        const double offset = dot(normal, a), reach = height * length3(nx, ny, nz), unscale = 1 / x.scale();
        if (const auto axis = std::ranges::find_if(normal, [](double n) { return n != 0; });
            std::count(normal.begin(), normal.end(), 0.0) == 2) {
            const auto k = static_cast<std::size_t>(axis - normal.begin());
            thin_[static_cast<std::size_t>(pair_of(static_cast<int>(k)))] = true;
            sides_.lower[k] = (a[k] - height) * unscale;
            sides_.upper[k] = (a[k] + height) * unscale;
            continue;
        }
        walls_.push_back({normal, (offset + reach) * unscale});
        walls_.push_back({{-nx, -ny, -nz}, (reach - offset) * unscale});
    }
}

bool FlatEnds::holds(const Vector3& x) const {
    Point scaled;
    for (std::size_t k = 0; k < 3; ++k) {
        scaled[k] = ignored_[k] ? 0 : x[k] * scale_;
        if (!(std::abs(scaled[k]) <= farthest_) || (!ignored_[k] && scaled[k] / scale_ != x[k])) return false;
    }
    return std::ranges::all_of(planes_, [&](const FlatPlane& plane) {
        const auto& [a, b, c] = plane.points;
        return exact::orient(a, b, c, scaled) == 0;
    });
}

void FlatEnds::cut(Region& region) const {
    region.walls = walls_;
    for (std::size_t j = 0; j < 3; ++j) {
        if (!thin_[j]) continue;
        const auto k = static_cast<std::size_t>(axes_[j]);
        set_ends(region, j, axes_[j], sides_.lower[k], sides_.upper[k]);
    }
}

int FlatEnds::pair_of(int axis) const {
    const auto pair = std::ranges::find(axes_, axis);
    return pair == axes_.end() ? -1 : static_cast<int>(pair - axes_.begin());
}

}  // namespace votess

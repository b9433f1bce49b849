#include "triangulate/power_sites.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/arithmetic.hpp"
#include "exact/determinant.hpp"
#include "exact/double_double.hpp"

namespace votess::cpu {
namespace {

// A difference of places is wrong by at most 3 units of its size, which subtract() finds; a lifted one by 11, since its
// squares are wrong by 7 and it adds weights. A determinant of 3 rows sums 6 products of 3 differences, 14 roundings
// each. One of 4 rows sums 4 of these times a lift, 29 roundings each.
constexpr double unit = 0x1p-53;
constexpr double orient_factor = 100 * unit, insphere_factor = 800 * unit;
// An upper bound of all underflow, with coordinates and weights within these.
constexpr double underflow = 1e-200, max_coordinate = 0x1p90, max_weight = 0x1p180;
constexpr double place_precision = 0x1p-98;  // of a place near others, relative to coordinates and shifts

}  // namespace

PowerSites::PowerSites(std::vector<Site> sites, const exact::Lattice* lattice)
    : sites_(std::move(sites)), lattice_(lattice) {
    for (const exact::Point& point : {exact::Point{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
        sites_.push_back({point, {}, 0});
    find_places();
}

void PowerSites::find_places() {
    double farthest = 0, heaviest = 0;
    bool shifted = false;
    places_.reserve(sites_.size());
    for (const Site& site : sites_) {
        Place place{site.point, {}};
        for (const double x : site.point) farthest = std::max(farthest, std::abs(x));
        if (site.shift != exact::Shift{}) {
            shifted = true;
            const auto at = exact::differences({}, exact::Plane::bisector(site.point, site.shift, *lattice_));
            for (std::size_t k = 0; k < 3; ++k) {
                place.high[k] = at.x[k].high;
                place.low[k] = at.x[k].low;
                double far = std::abs(site.point[k]);
                for (std::size_t j = 0; j < 3; ++j) far += std::abs(site.shift[j] * lattice_->vector[j][k].high);
                farthest = std::max(farthest, far);
            }
        }
        heaviest = std::max(heaviest, std::abs(site.weight));
        places_.push_back(place);
    }
    if (!(farthest <= max_coordinate && heaviest <= max_weight)) places_.clear();  // NaN, too
    if (shifted) place_error_ = place_precision * farthest;
}

// Raises size to the difference, and to the terms of its error.
inline void PowerSites::subtract(std::int32_t from, std::int32_t last, exact::Point& row, exact::Point& size) const {
    const Place &a = places_[static_cast<std::size_t>(from)], &b = places_[static_cast<std::size_t>(last)];
    for (std::size_t k = 0; k < 3; ++k) {
        const double low = a.low[k] - b.low[k];
        row[k] = (a.high[k] - b.high[k]) + low;
        size[k] = std::max(size[k], std::abs(row[k]) + std::abs(low));
    }
}

int PowerSites::orient(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const {
    if (!places_.empty()) {
        std::array<exact::Point, 3> rows;
        exact::Point size{};
        subtract(a, d, rows[0], size);
        subtract(b, d, rows[1], size);
        subtract(c, d, rows[2], size);
        for (double& x : size) x += place_error_ / unit;
        const double estimate = exact::determinant(rows[0], rows[1], rows[2]);
        if (std::abs(estimate) > orient_factor * (size[0] * size[1] * size[2]) + underflow)
            return estimate > 0 ? 1 : -1;
    }
    return exact::orientation(point_of(d), bisector(d, a), bisector(d, b), bisector(d, c));
}

int PowerSites::insphere(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d, std::int32_t p) const {
    if (!places_.empty()) {
        struct Row {
            exact::Point x;
            double lift = 0;
            double operator[](std::size_t k) const { return x[k]; }
        };
        std::array<Row, 4> rows;
        exact::Point size{};
        double more = 0;
        const double weight = sites_[static_cast<std::size_t>(d)].weight;
        const std::array others{a, b, c, p};
        for (std::size_t i = 0; i < 4; ++i) {
            Row& row = rows[i];
            subtract(others[i], d, row.x, size);
            const double excess = weight - sites_[static_cast<std::size_t>(others[i])].weight;
            row.lift = (row.x[0] * row.x[0] + row.x[1] * row.x[1] + row.x[2] * row.x[2]) + excess;
            more = std::max(more, std::abs(excess));
        }
        for (double& x : size) x += place_error_ / unit;
        const double lifted = size[0] * size[0] + size[1] * size[1] + size[2] * size[2] + more;
        const double estimate =
            exact::lifted_determinant(rows[0], rows[1], rows[2], rows[3], [](const Row& row) { return row.lift; });
        const double bound = insphere_factor * (size[0] * size[1] * size[2] * lifted) + underflow;
        if (std::abs(estimate) > bound) return estimate > 0 ? -1 : 1;
    }
    const std::array planes{bisector(d, a), bisector(d, b), bisector(d, c), bisector(d, p)};
    const auto side = [&](const auto& of) { return exact::side_of_vertex(point_of(d), of[0], of[1], of[2], of[3]); };
    if (const int sign = side(planes); sign != 0) return sign;
    // Ties are decided as if weights grew by an infinitesimal part of |x|^2. That hides sites between others whose
    // cells have no volume: they would part the neighbors on both sides of them.
    auto plain = planes;
    for (exact::Plane& plane : plain) plane.power = {};
    return -side(plain);
}

exact::Plane PowerSites::bisector(std::int32_t from, std::int32_t to) const {
    const Site &a = sites_[static_cast<std::size_t>(from)], &b = sites_[static_cast<std::size_t>(to)];
    exact::Plane plane = exact::Plane::bisector(b.point);
    if (lattice_ != nullptr) {
        exact::Shift by = b.shift;
        for (std::size_t j = 0; j < by.size(); ++j) by[j] -= a.shift[j];
        plane = exact::Plane::bisector(b.point, by, *lattice_);
    }
    plane.power = exact::two_sum(a.weight, -b.weight);
    return plane;
}

}  // namespace votess::cpu

#include "triangulate/delaunay.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/progress.hpp"
#include "core/scrambled.hpp"

namespace votess::cpu {
namespace {

// Uniform seeds have 7 tetrahedra each, infinite ones included.
constexpr std::size_t max_cells_per_seed = 64, max_cells_of_few = 4'000'000;
constexpr int first_round_bits = 8;

// Rounds of twice as many random seeds as before, each in spatial order (Amenta, Choi, Rote, Incremental constructions
// con BRIO, SoCG 2003). So successive seeds are near each other, yet the inserted seeds are always spread everywhere.
std::vector<std::int32_t> insertion_order(std::size_t count) {
    const int rounds = std::max(0, static_cast<int>(std::bit_width(count)) - first_round_bits) + 1;
    auto round_of = [&](std::size_t i) { return rounds - 1 - std::min(rounds - 1, std::countr_zero(scrambled(i))); };
    std::vector<std::size_t> begin(static_cast<std::size_t>(rounds) + 1);
    in_pieces(count, [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) ++begin[round_of(i) + 1];
    });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::int32_t> order(count);
    in_pieces(count, [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) order[begin[round_of(i)]++] = static_cast<std::int32_t>(i);
    });
    return order;
}

// Returns the points, then four of which some are added to seeds that span no tetrahedron.
std::vector<exact::Point> points_of(std::size_t count, std::span<const double> x, std::span<const double> y,
                                    std::span<const double> z) {
    // Seeds that are small beside their box get the size that filters are made for.
    double largest = 0;
    for (std::size_t i = 0; i < count; ++i)
        largest = std::max({largest, std::abs(x[i]), std::abs(y[i]), std::abs(z[i])});
    constexpr double small = 0x1p-64, smallest = 0x1p-1000;
    const double scale = largest < small && largest > smallest ? std::ldexp(1.0, -std::ilogb(largest)) : 1;
    std::vector<exact::Point> points;
    points.reserve(count + 4);
    for (std::size_t i = 0; i < count; ++i) points.push_back({x[i] * scale, y[i] * scale, z[i] * scale});
    points.insert(points.end(), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    return points;
}

}  // namespace

Delaunay::Delaunay(std::size_t count, std::span<const double> x, std::span<const double> y, std::span<const double> z)
    : Delaunay(count, PointSites(points_of(count, x, y, z))) {}

Delaunay::Delaunay(std::size_t count, const Sites& sites) : count_(count) {
    first_.assign(count_ + 4, Triangulation::unused);
    Triangulation triangulation(sites);
    valid_ = count_ < 2 || triangulate(triangulation, sites);
    if (!valid_) return;
    cells_ = triangulation.take();
    list_by_vertex();
}

bool Delaunay::triangulate(Triangulation& triangulation, const Sites& sites) const {
    std::vector<std::int32_t> order = insertion_order(count_);
    // Coplanar seeds get a point beside their plane, collinear ones two. Then every tetrahedron joins triangles (pairs)
    // of seeds to these points. Wherever the points are, its circumsphere meets the plane (line) in the circle of the
    // triangle (the pair), so its answers about seeds stay right.
    const auto added = static_cast<std::int32_t>(count_);
    auto is_beside = [&](std::int32_t a, std::int32_t b, std::int32_t c) {  // not collinear
        for (std::int32_t d = added; d < added + 4; ++d)
            if (sites.orient(a, b, c, d) != 0) return true;
        return false;
    };
    auto first_of = [&](auto suits) {
        const auto found = std::find_if(order.begin() + 1, order.end(), suits);
        if (found != order.end()) return *found;
        std::int32_t point = added;
        while (!suits(point)) ++point;
        return point;
    };
    const std::int32_t a = order[0];
    // With weights two seeds may have one place, which is on a line with any other.
    const std::int32_t b = first_of([&](std::int32_t p) {
        for (std::int32_t c = added; c < added + 4; ++c)
            if (is_beside(a, p, c)) return true;
        return false;
    });
    const std::int32_t c = first_of([&](std::int32_t p) { return is_beside(a, b, p); });
    const std::int32_t d = first_of([&](std::int32_t p) { return sites.orient(a, b, c, p) != 0; });
    triangulation.begin(a, b, c, d);

    const std::size_t most = std::min<std::size_t>(std::max(max_cells_per_seed * count_, max_cells_of_few),
                                                   std::numeric_limits<std::int32_t>::max() - std::size_t{1'000'000});
    for (std::size_t k = 1; k < count_; ++k) {
        const std::int32_t p = order[k];
        if (p == b || p == c || p == d) continue;
        check_stop();
        triangulation.insert(p);
        if (triangulation.tetrahedra().size() > most) return false;
    }
    return true;
}

void Delaunay::list_by_vertex() {
    in_pieces(cells_.size(), [this](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Tetrahedron& t = cells_[i];
            if (!Triangulation::is_finite(t)) continue;  // nor unused
            for (int k = 0; k < 4; ++k) {
                t.neighbor[k] = first_[t.vertex[k]];
                first_[t.vertex[k]] = static_cast<std::int32_t>(i);
            }
        }
    });
}

void Delaunay::neighbors(std::size_t seed, std::vector<std::int32_t>& out, std::vector<std::uint8_t>& marks) const {
    out.clear();
    marks.resize(std::max(marks.size(), count_), 0);
    const auto self = static_cast<std::int32_t>(seed), end = static_cast<std::int32_t>(count_);
    for (std::int32_t cell = first_[seed]; cell >= 0;) {
        const Tetrahedron& t = cells_[cell];
        int own = 0;
        for (int k = 0; k < 4; ++k) {
            if (t.vertex[k] == self)
                own = k;
            else if (t.vertex[k] < end && marks[t.vertex[k]] == 0) {
                marks[t.vertex[k]] = 1;
                out.push_back(t.vertex[k]);
            }
        }
        cell = t.neighbor[own];
    }
    for (const std::int32_t neighbor : out) marks[neighbor] = 0;
}

}  // namespace votess::cpu

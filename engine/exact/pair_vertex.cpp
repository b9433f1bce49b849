#include "exact/pair_vertex.hpp"

#include <algorithm>
#include <cmath>

#include "exact/integer/rows.hpp"

namespace votess::exact {
namespace {

constexpr double pair_rounding = 0x1p-99;  // u^2 is 2^-106; above the 48.3 and the rounding of A
constexpr double largest_in_pairs = 0x1p150, least_bound = 0x1p-590;

DoubleDouble operator-(const DoubleDouble& x) {
    return {-x.high, -x.low};
}

// Returns the sign of a sum, or 0 if rounding may have changed it.
int sure_sign(const DoubleDouble& value, double size) {
    const double bound = std::max(pair_rounding * size, least_bound);
    return value.high > bound ? 1 : value.high < -bound ? -1 : 0;
}

}  // namespace

// Returns false if pairs do not hold the differences.
bool PairVertex::write_row(const Point& p, const Plane& plane, Row& row) {
    if (plane.is_oblique()) return false;
    if (!plane.is_bisector()) {
        const auto [sign, distance] = wall_difference(p, plane);
        row.n[static_cast<std::size_t>(plane.axis)].high = sign;
        row.s = {2 * distance.high, 2 * distance.low};
        row.size_s = std::abs(row.s.high);
        return row.size_s <= largest_in_pairs;
    }
    const Differences difference = differences(p, plane);
    if (!difference.exact) return false;
    row.n = difference.x;
    double largest = 0;
    for (const DoubleDouble& x : row.n) {
        largest = std::max(largest, std::abs(x.high));
        row.s = row.s + x * x;
    }
    row.size_s = row.s.high + std::abs(plane.power.high);
    row.s = row.s + plane.power;
    if (plane.is_reversed()) {
        for (DoubleDouble& x : row.n) x = -x;
        row.s = -row.s;
    }
    return largest <= largest_in_pairs && row.size_s <= largest_in_pairs * largest_in_pairs;
}

PairVertex::PairVertex(const Point& p, const Plane& a, const Plane& b, const Plane& c) : p_(p) {
    std::array<Row, 3> rows;
    if (!write_row(p, a, rows[0]) || !write_row(p, b, rows[1]) || !write_row(p, c, rows[2])) return;
    for (std::size_t r = 0; r < 3; ++r) {
        const Row &own = rows[r], &next = rows[(r + 1) % 3], &last = rows[(r + 2) % 3];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
            const DoubleDouble first = next.n[i] * last.n[j], second = next.n[j] * last.n[i];
            const DoubleDouble minor = first + -second;
            const double size = std::abs(first.high) + std::abs(second.high);
            v_[k].value = v_[k].value + own.s * minor;
            v_[k].size += own.size_s * size;
            if (r > 0) continue;
            determinant_.value = determinant_.value + own.n[k] * minor;
            determinant_.size += std::abs(own.n[k].high) * size;
        }
    }
    sign_ = sure_sign(determinant_.value, determinant_.size);
}

int PairVertex::side(const Plane& d) const {
    Row row;
    if (sign_ == 0 || !write_row(p_, d, row)) return 0;
    DoubleDouble excess = -(row.s * determinant_.value);
    double size = row.size_s * determinant_.size;
    for (std::size_t k = 0; k < 3; ++k) {
        excess = excess + row.n[k] * v_[k].value;
        size += std::abs(row.n[k].high) * v_[k].size;
    }
    return sure_sign(excess, size) * sign_;
}

}  // namespace votess::exact

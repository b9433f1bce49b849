#include "exact/pair_vertex.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "exact/double_double.hpp"
#include "exact/integer/rows.hpp"

namespace votess::exact {
namespace {

constexpr double pair_rounding = 0x1p-99;  // u^2 is 2^-106; above the 48.3 and the rounding of A
constexpr double largest_in_pairs = 0x1p150, least_bound = 0x1p-590;

// A plane: 2 N.X <= S. size_s: the absolute values of the terms of S.
struct PairRow {
    std::array<DoubleDouble, 3> n{};
    DoubleDouble s;
    double size_s = 0;
};
struct SizedPair {  // with the absolute values of its terms
    DoubleDouble value;
    double size = 0;
};

DoubleDouble operator-(const DoubleDouble& x) {
    return {-x.high, -x.low};
}

// Returns the sign of a sum, or 0 if rounding may have changed it.
int sure_sign(const DoubleDouble& value, double size) {
    const double bound = std::max(pair_rounding * size, least_bound);
    return value.high > bound ? 1 : value.high < -bound ? -1 : 0;
}

// Returns false if pairs do not hold the differences.
bool write_row(const Point& p, const Plane& plane, PairRow& row) {
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

}  // namespace

int side_in_pairs(const Point& p, const Plane& a, const Plane& b, const Plane& c, const Plane& d) {
    std::array<PairRow, 4> rows;
    if (!write_row(p, a, rows[0]) || !write_row(p, b, rows[1]) || !write_row(p, c, rows[2]) ||
        !write_row(p, d, rows[3]))
        return 0;
    std::array<SizedPair, 3> v{};
    SizedPair determinant;
    for (std::size_t r = 0; r < 3; ++r) {
        const PairRow &own = rows[r], &next = rows[(r + 1) % 3], &last = rows[(r + 2) % 3];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
            const DoubleDouble first = next.n[i] * last.n[j], second = next.n[j] * last.n[i];
            const DoubleDouble minor = first + -second;
            const double size = std::abs(first.high) + std::abs(second.high);
            v[k].value = v[k].value + own.s * minor;
            v[k].size += own.size_s * size;
            if (r > 0) continue;
            determinant.value = determinant.value + own.n[k] * minor;
            determinant.size += std::abs(own.n[k].high) * size;
        }
    }
    const PairRow& of_d = rows[3];
    DoubleDouble excess = -(of_d.s * determinant.value);
    double size = of_d.size_s * determinant.size;
    for (std::size_t k = 0; k < 3; ++k) {
        excess = excess + of_d.n[k] * v[k].value;
        size += std::abs(of_d.n[k].high) * v[k].size;
    }
    return sure_sign(excess, size) * sure_sign(determinant.value, determinant.size);
}

}  // namespace votess::exact

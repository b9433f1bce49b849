#include "exact/vertex.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/arithmetic.hpp"
#include "exact/double_double.hpp"
#include "exact/integer/rows.hpp"

namespace votess::exact {
namespace {

constexpr double rounding = 20 * 0x1p-53;  // above the 17 of vertex.hpp
constexpr double exact_limit = 0x1p52;     // leaves A room for its own rounding
constexpr int lowest_quantum = -1000;      // 2^1000 is still finite
constexpr int coarse_bits = 6;             // differences of a lattice, in its quanta
constexpr int exact_bits = 10;             // beyond them A <= 2^52 is rare
constexpr int fine_bits = 57;              // leaves planes d up to 8 times longer within 61 bits
constexpr int max_plane_bits = 120;        // A < 2^700; finer planes are decided one by one

// True for planes that the fast ways can handle.
bool in_two_doubles(const Point& p, const Plane& plane) {
    if (plane.has_power() || plane.is_reversed() || plane.is_oblique()) return false;
    return plane.plain() || image_differences(p, plane).exact;
}

// Adds all the bits of the differences of a plane.
void add_differences(BitRange& range, const Point& p, const Plane& plane) {
    auto add = [&range](DoubleDouble d) {
        range.add(d.high);
        range.add(d.low);
    };
    if (!plane.is_bisector()) return add(wall_difference(p, plane).distance);
    for (const DoubleDouble& x : differences(p, plane).x) add(x);
}

// A plane in quanta, in double.
struct FloatRow {
    std::array<double, 3> n{};
    double s = 0;
    bool whole = true;  // the quantum divides all differences
};

bool divides(double unit, double per_unit, double x) {
    const double quanta = x * per_unit;
    if (std::abs(quanta) < 0x1p53) return static_cast<double>(static_cast<std::int64_t>(quanta)) * unit == x;
    return std::abs(quanta) <= std::numeric_limits<double>::max();
}

FloatRow float_row(const Point& p, const Plane& plane, double unit, double per_unit) {
    FloatRow row;
    std::array<DoubleDouble, 3> difference{};
    if (plane.is_bisector()) {
        difference = differences(p, plane).x;
        for (int k = 0; k < 3; ++k) row.n[k] = difference[k].high * per_unit;
        row.s = row.n[0] * row.n[0] + row.n[1] * row.n[1] + row.n[2] * row.n[2];
    } else {
        const auto [sign, distance] = wall_difference(p, plane);
        difference[0] = distance;
        row.n[plane.axis] = sign;
        row.s = 2 * (distance.high * per_unit);
    }
    const auto& [x, y, z] = difference;
    const bool exact = x.low == 0 && y.low == 0 && z.low == 0;
    // Adding 2^52 rounds smaller numbers to integers.
    auto rounded = [=](double d) { return ((d * per_unit + 0x1.8p52) - 0x1.8p52) * unit; };
    const double largest = std::max({std::abs(x.high), std::abs(y.high), std::abs(z.high)}) * per_unit;
    if (exact && largest < 0x1p51) {
        row.whole = (rounded(x.high) == x.high && rounded(y.high) == y.high && rounded(z.high) == z.high);
    } else {
        for (const auto& d : difference) row.whole &= divides(unit, per_unit, d.high) && divides(unit, per_unit, d.low);
    }
    return row;
}

// Writes a plane in quanta, exact. Returns false when a difference may reach 2^61.
bool int_row(const Point& p, const Plane& plane, double per_unit, IntRow& row) {
    bool fits = true;
    auto quanta = [&](DoubleDouble d) -> std::int64_t {
        const double high = d.high * per_unit;
        if (!(std::abs(high) < 0x1p60)) {
            fits = false;
            return 0;
        }
        return static_cast<std::int64_t>(high) + static_cast<std::int64_t>(d.low * per_unit);
    };
    row = {};
    if (plane.is_bisector()) {
        const Differences difference = differences(p, plane);
        for (int k = 0; k < 3; ++k) {
            row.n[k] = quanta(difference.x[k]);
            row.s += static_cast<Int128>(row.n[k]) * row.n[k];
        }
    } else {
        const auto [sign, distance] = wall_difference(p, plane);
        row.n[plane.axis] = sign < 0 ? -1 : 1;
        row.s = 2 * static_cast<Int128>(quanta(distance));
    }
    return fits;
}

}  // namespace

ExactVertex::ExactVertex(const Point& p, const Plane& a, const Plane& b, const Plane& c) : p_(p), a_(a), b_(b), c_(c) {
    if (!in_two_doubles(p, a) || !in_two_doubles(p, b) || !in_two_doubles(p, c)) return;
    const double largest = std::max({largest_difference(p, a), largest_difference(p, b), largest_difference(p, c)});
    if (!(largest <= std::numeric_limits<double>::max())) return;
    exponent_ = exponent_above(largest);
    quantum_ = std::max(exponent_ - coarse_bits, lowest_quantum);
    usable_ = solve() || (refine(a) && refine(b) && refine(c) && solve());
}

bool ExactVertex::refine(const Plane& plane) {
    BitRange range;
    add_differences(range, p_, plane);
    if (range.span() == 0) return true;
    if (range.low < std::max(lowest_quantum, exponent_ - max_plane_bits)) return false;
    quantum_ = std::min(quantum_, range.low);
    // Double is not exact here anyway, so a quantum so fine that few planes need a finer one.
    if (exponent_ - quantum_ > exact_bits)
        quantum_ = std::min(quantum_, std::max(exponent_ - fine_bits, lowest_quantum));
    return true;
}

bool ExactVertex::solve() {
    unit_ = power_of_two(quantum_);
    per_unit_ = power_of_two(-quantum_);
    state_ = State::unknown;
    const FloatRow a = float_row(p_, a_, unit_, per_unit_);
    if (!a.whole) return false;
    const FloatRow b = float_row(p_, b_, unit_, per_unit_);
    if (!b.whole) return false;
    const FloatRow c = float_row(p_, c_, unit_, per_unit_);
    if (!c.whole) return false;
    determinant_ = determinant_bound_ = 0;
    for (int k = 0; k < 3; ++k) {
        const int i = k == 2 ? 0 : k + 1, j = k == 0 ? 2 : k - 1;
        auto minor = [i, j](const FloatRow& r, const FloatRow& s, double& bound) {
            const double first = r.n[i] * s.n[j], second = r.n[j] * s.n[i];
            bound = std::abs(first) + std::abs(second);
            return first - second;
        };
        double bc_bound = 0, ca_bound = 0, ab_bound = 0;
        const double bc = minor(b, c, bc_bound), ca = minor(c, a, ca_bound), ab = minor(a, b, ab_bound);
        v_[k] = a.s * bc + b.s * ca + c.s * ab;
        v_bound_[k] = std::abs(a.s) * bc_bound + std::abs(b.s) * ca_bound + std::abs(c.s) * ab_bound;
        determinant_ += a.n[k] * bc;
        determinant_bound_ += std::abs(a.n[k]) * bc_bound;
    }
    const bool certain = std::abs(determinant_) > rounding * determinant_bound_ || determinant_bound_ <= exact_limit;
    sign_ = certain ? sign_of(determinant_) : 0;
    return true;
}

int ExactVertex::side(const Plane& d) {
    if (!usable_ || !in_two_doubles(p_, d)) return side_of_wide(d);
    FloatRow row = float_row(p_, d, unit_, per_unit_);
    if (!row.whole) {
        if (refine(d)) {
            usable_ = solve();
            row = float_row(p_, d, unit_, per_unit_);
        }
        if (!usable_ || !row.whole) return side_of_wide(d);
    }
    if (sign_ != 0) {
        const double excess = row.n[0] * v_[0] + row.n[1] * v_[1] + row.n[2] * v_[2] - row.s * determinant_;
        const double bound = std::abs(row.n[0]) * v_bound_[0] + std::abs(row.n[1]) * v_bound_[1] +
                             std::abs(row.n[2]) * v_bound_[2] + std::abs(row.s) * determinant_bound_;
        if (std::abs(excess) > rounding * bound || bound <= exact_limit) return sign_of(excess) * sign_;
    }
    return side_integers(d);
}

int ExactVertex::side_of_wide(const Plane& d) {
    if (!pairs_) pairs_.emplace(p_, a_, b_, c_);
    const int side = pairs_->side(d);
    return side != 0 ? side : side_of_any(p_, a_, b_, c_, d);
}

void ExactVertex::solve_integers() {
    IntRow a, b, c;
    state_ = State::too_wide;
    if (!int_row(p_, a_, per_unit_, a) || !int_row(p_, b_, per_unit_, b) || !int_row(p_, c_, per_unit_, c)) return;
    integers_ = IntVertex(a, b, c);
    state_ = State::known;
}

int ExactVertex::side_integers(const Plane& d) {
    if (state_ == State::unknown) solve_integers();
    IntRow row;
    if (state_ == State::too_wide || !int_row(p_, d, per_unit_, row)) return side_of_wide(d);
    return integers_.side(row);
}

}  // namespace votess::exact

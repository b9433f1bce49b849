#include "exact/tied_seeds.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/arithmetic.hpp"
#include "core/vector3.hpp"
#include "exact/double_double.hpp"

namespace votess::exact {
namespace {

constexpr int bits = 57;                                       // leaves seeds up to 8 times farther below 2^60
constexpr int lowest_exponent = -900, highest_exponent = 900;  // the unit and its inverse are normal

double largest_coordinate(const Differences& d) {
    return std::max({std::abs(d.x[0].high), std::abs(d.x[1].high), std::abs(d.x[2].high)});
}

}  // namespace

bool TiedSeeds::begin(const Differences& a, const Differences& b, const Differences& c) {
    const double largest = std::max({largest_coordinate(a), largest_coordinate(b), largest_coordinate(c)});
    const int exponent = exponent_above(largest);
    at_[0] = {};
    count_ = 4;
    solved_ = false;
    usable_ = exponent > lowest_exponent && exponent < highest_exponent;
    if (!usable_) return false;
    unit_ = power_of_two(exponent - bits);
    per_unit_ = power_of_two(bits - exponent);
    return usable_ = place(a, at_[1]) && place(b, at_[2]) && place(c, at_[3]);
}

IntRow TiedSeeds::row(const WordVector& n) {
    const auto square = [](std::int64_t x) { return static_cast<Int128>(x) * x; };
    return {n, square(n[0]) + square(n[1]) + square(n[2])};
}

// Returns false when a coordinate is not an integer below 2^60 times the unit.
bool TiedSeeds::place(const Differences& seed, WordVector& out) const {
    bool whole = seed.exact;
    const auto units = [&](double x) {
        const double scaled = x * per_unit_;
        if (!(std::abs(scaled) < 0x1p60)) {
            whole = false;
            return std::int64_t{0};
        }
        const auto n = static_cast<std::int64_t>(scaled);
        whole &= static_cast<double>(n) * unit_ == x;
        return n;
    };
    for (std::size_t k = 0; k < 3; ++k) {
        out[k] = units(seed.x[k].high);
        if (seed.x[k].low != 0) out[k] += units(seed.x[k].low);
    }
    return whole;
}

std::optional<int> TiedSeeds::side(const Differences& seed) {
    WordVector d;
    usable_ = usable_ && count_ < max_seeds && place(seed, d);
    if (!usable_) return {};
    int side = 0;
    if (!completes_rectangle(d)) {
        if (!solved_) vertex_ = IntVertex(row(at_[1]), row(at_[2]), row(at_[3]));
        solved_ = true;
        side = vertex_.side(row(d));
    }
    if (side == 0) at_[count_++] = d;
    return side;
}

// Whether d and the first seed, 0, are corners of a rectangle with two of the others: 0, i, d, j has d = i + j and a
// right angle at 0; 0, d, i, j has i = d + j, with the same angle. Products stay below 2^122.
bool TiedSeeds::completes_rectangle(const WordVector& d) const {
    const auto is_sum = [](const WordVector& sum, const WordVector& a, const WordVector& b) {
        return a[0] + b[0] == sum[0] && a[1] + b[1] == sum[1] && a[2] + b[2] == sum[2];
    };
    const auto orthogonal = [](const WordVector& a, const WordVector& b) {
        return static_cast<Int128>(a[0]) * b[0] + static_cast<Int128>(a[1]) * b[1] + static_cast<Int128>(a[2]) * b[2] ==
               0;
    };
    for (std::size_t i = 1; i < count_; ++i)
        for (std::size_t j = 1; j < count_; ++j) {
            const WordVector &p = at_[i], &q = at_[j];
            if ((j < i && is_sum(d, p, q) && orthogonal(p, q)) || (is_sum(p, d, q) && orthogonal(d, q))) return true;
        }
    return false;
}

WordVector TiedSeeds::difference(std::size_t a, std::size_t b) const {
    const WordVector &from = at_[a], &to = at_[b];
    return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

// Adds the facet to the left of an edge of the hull. third: any seed, or with is_facet a seed of that facet.
bool TiedSeeds::add_facet(Edge edge, std::size_t third, bool is_facet) {
    const std::size_t a = edge.from, b = edge.to;
    std::array<std::uint8_t, max_seeds> ring;
    ring[0] = edge.from;
    ring[1] = edge.to;
    ring[2] = static_cast<std::uint8_t>(third);
    std::size_t size = 3, inside = a;
    const WordVector along = difference(a, b);
    const auto side = [&](std::size_t seed) { return WordCross(along, difference(a, seed)); };
    WordCross facet = side(third);
    for (std::size_t seed = 0; seed < count_; ++seed) {
        if (seed == a || seed == b || seed == third) continue;
        const int on = facet.turn(difference(a, seed));
        if (on < 0) {
            inside = seed;
        } else if (on == 0) {
            ring[size++] = static_cast<std::uint8_t>(seed);
        } else {  // The seeds so far are inside of the new facet.
            if (is_facet) return false;
            inside = ring[2];
            facet = side(seed);
            ring[2] = static_cast<std::uint8_t>(seed);
            size = 3;
        }
    }
    if (inside == a) return false;
    // Sorts the others around the first. An edge of the hull leads to the second.
    const std::size_t first = is_facet ? 1 : 2;
    for (std::size_t k = 3; k < size; ++k) {
        const std::uint8_t seed = ring[k];
        std::size_t at = k;
        for (; at > first; --at) {
            const int turn = WordCross(difference(a, ring[at - 1]), difference(a, seed)).turn(difference(a, inside));
            if (turn == 0) return false;
            if (turn < 0) break;
            ring[at] = ring[at - 1];
        }
        ring[at] = seed;
    }
    for (std::size_t k = 0; k < size; ++k) {
        const std::uint8_t before = ring[k == 0 ? size - 1 : k - 1], at = ring[k],
                           after = ring[k + 1 == size ? 0 : k + 1];
        if ((facets_[at] >> after & 1) != 0 || pending_count_ == pending_.size()) return false;
        facets_[at] |= 1ull << after;
        next_[at][before] = after;
        pending_[pending_count_] = {after, at};
        pending_count_ += static_cast<std::size_t>(~facets_[after] >> at & 1);
    }
    return true;
}

bool TiedSeeds::wrap() {
    std::uint64_t any = 0;
    for (std::size_t s = 0; s < count_; ++s)
        any |= static_cast<std::uint64_t>(at_[s][0]) | static_cast<std::uint64_t>(at_[s][1]) |
               static_cast<std::uint64_t>(at_[s][2]);
    const int zeros = std::countr_zero(any);
    for (std::size_t s = 0; s < count_; ++s)
        for (std::int64_t& x : at_[s]) x >>= zeros;
    std::fill_n(facets_.begin(), count_, 0);
    if (count_ == 8 && wrap_parallelepiped()) return true;
    pending_count_ = 0;
    if (!add_facet({0, 1}, 2, true)) return false;
    while (pending_count_ > 0) {
        const Edge edge = pending_[--pending_count_];
        if ((facets_[edge.from] >> edge.to & 1) != 0) continue;
        std::size_t third = 0;
        while (third == edge.from || third == edge.to) ++third;
        if (!add_facet(edge, third, false)) return false;
    }
    return std::all_of(facets_.begin(), facets_.begin() + static_cast<std::ptrdiff_t>(count_),
                       [](std::uint64_t known) { return known != 0; });
}

// Eight seeds may be 0, u, v, u + v and these plus w, as in most lattices.
bool TiedSeeds::wrap_parallelepiped() {
    std::array<std::size_t, 8> corner{0, 1, 2};  // bits 0, 1, 2: the sum has u, v, w
    const auto find_sum = [&](std::size_t bits, std::size_t a, std::size_t b) {
        const WordVector sum{at_[a][0] + at_[b][0], at_[a][1] + at_[b][1], at_[a][2] + at_[b][2]};
        corner[bits] = 3;
        while (corner[bits] < 8 && at_[corner[bits]] != sum) ++corner[bits];
        return corner[bits] < 8;
    };
    if (!find_sum(3, 1, 2)) return false;
    std::size_t& w = corner[4] = 3;
    while (w < 8 && !(find_sum(5, 1, w) && find_sum(6, 2, w) && find_sum(7, corner[3], w))) ++w;
    if (w == 8 || WordCross(at_[1], at_[2]).turn(at_[w]) >= 0) return false;
    for (std::size_t bits = 0; bits < 8; ++bits) {
        auto x = static_cast<std::uint8_t>(corner[bits ^ 1]), y = static_cast<std::uint8_t>(corner[bits ^ 2]);
        const auto z = static_cast<std::uint8_t>(corner[bits ^ 4]);
        if (std::popcount(bits) % 2 != 0) std::swap(x, y);
        facets_[corner[bits]] = 1ull << x | 1ull << y | 1ull << z;
        auto& next = next_[corner[bits]];
        next[x] = z, next[z] = y, next[y] = x;
    }
    return true;
}

std::span<const std::uint8_t> TiedSeeds::around(std::size_t seed) {
    const auto first = static_cast<std::uint8_t>(std::countr_zero(facets_[seed]));
    std::size_t size = 0;
    std::uint8_t at = first;
    do {
        around_[size++] = at;
        at = next_[seed][at];
    } while (at != first && size < max_seeds);
    return std::span(around_).first(size);
}

}  // namespace votess::exact

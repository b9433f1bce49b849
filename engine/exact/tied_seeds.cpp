#include "exact/tied_seeds.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "exact/integer/normals.hpp"

namespace votess::exact {
namespace {

constexpr double rounding = 10 * 0x1p-53, exact_limit = 0x1p52;  // room for the rounding of A

}  // namespace

std::array<double, 3> TiedSeeds::difference(int a, int b) const {
    const auto &from = at_[static_cast<std::size_t>(a)], &to = at_[static_cast<std::size_t>(b)];
    return {static_cast<double>(to[0] - from[0]), static_cast<double>(to[1] - from[1]),
            static_cast<double>(to[2] - from[2])};
}

TiedSeeds::Facet TiedSeeds::through(int a, int b, int c) const {
    Facet facet{a, b, c, {}, {}};
    const auto ab = difference(a, b), ac = difference(a, c);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = k == 2 ? 0 : k + 1, j = k == 0 ? 2 : k - 1;
        const double plus = ab[i] * ac[j], minus = ab[j] * ac[i];
        facet.normal[k] = plus - minus;
        facet.bound[k] = std::abs(plus) + std::abs(minus);
    }
    return facet;
}

// Returns +1 outside of the facet's plane, -1 inside, 0 on it.
int TiedSeeds::side(const Facet& facet, int seed) const {
    const auto d = difference(facet.a, seed);
    const double excess = dot(facet.normal, d);
    const double bound = facet.bound[0] * std::abs(d[0]) + facet.bound[1] * std::abs(d[1]) + facet.bound[2] * std::abs(d[2]);
    if (std::abs(excess) > rounding * bound || bound <= exact_limit) return sign_of(excess);
    return exact_side(facet, seed);
}

// Differences below 2^62 make determinants below 6 * 2^186 < 2^191.
int TiedSeeds::exact_side(const Facet& facet, int seed) const {
    const auto wide = [&](int to) {
        const auto &a = at_[static_cast<std::size_t>(facet.a)], &b = at_[static_cast<std::size_t>(to)];
        return std::array{from_int128<1>(b[0] - a[0]), from_int128<1>(b[1] - a[1]), from_int128<1>(b[2] - a[2])};
    };
    return sign_of(dot(wide(seed), cross(wide(facet.b), wide(facet.c))));
}

// Adds the facet to the left of an edge of the hull. third: any seed, or with is_facet a seed of that facet.
bool TiedSeeds::add_facet(Edge edge, int third, bool is_facet) {
    const int a = edge.from, b = edge.to;
    std::array<std::uint8_t, max_seeds> ring;
    std::size_t size = 0;
    Facet facet = through(a, b, third);
    int inside = -1;
    ring[size++] = edge.from;
    ring[size++] = edge.to;
    ring[size++] = static_cast<std::uint8_t>(third);
    for (int seed = 0; seed < count_; ++seed) {
        if (seed == a || seed == b || seed == third) continue;
        const int on = side(facet, seed);
        if (on < 0) {
            inside = seed;
        } else if (on == 0) {
            ring[size++] = static_cast<std::uint8_t>(seed);
        } else {  // All seeds so far are inside of the new facet.
            if (is_facet) return false;
            inside = facet.c;
            facet = through(a, b, seed);
            ring[2] = static_cast<std::uint8_t>(seed);
            size = 3;
        }
    }
    if (inside < 0) return false;
    // Sorts the others around the first.
    for (std::size_t k = 3; k < size; ++k) {
        const std::uint8_t seed = ring[k];
        std::size_t at = k;
        for (; at > 1; --at) {
            const int turn = side(through(a, ring[at - 1], seed), inside);
            if (turn == 0) return false;
            if (turn < 0) break;
            ring[at] = ring[at - 1];
        }
        ring[at] = seed;
    }
    for (std::size_t k = 0; k < size; ++k) {
        const std::uint8_t before = ring[k == 0 ? size - 1 : k - 1], at = ring[k], after = ring[k + 1 == size ? 0 : k + 1];
        if ((facets_[at] >> after & 1) != 0 || pending_count_ == pending_.size()) return false;
        facets_[at] |= 1ull << after;
        next_[at][before] = after;
        if ((facets_[after] >> at & 1) == 0) pending_[pending_count_++] = {after, at};
    }
    return true;
}

bool TiedSeeds::build(const Point& p, std::span<const Plane* const> bisectors) {
    const std::size_t count = bisectors.size() + 1;
    if (count < 4 || count > max_seeds) return false;
    for (const Plane* plane : bisectors)
        if (!plane->is_bisector() || plane->has_power()) return false;
    Scratch<Normal<std::int64_t>> words(count - 1);
    if (!word_normals<bits_for_word>(p, bisectors, words)) return false;
    reduce(bisectors, words);
    count_ = static_cast<int>(count);
    at_[0] = {};
    for (std::size_t k = 1; k < count; ++k) at_[k] = words[k - 1];
    std::fill_n(facets_.begin(), count, 0);
    pending_count_ = 0;
    if (!add_facet({0, 1}, 2, true)) return false;
    while (pending_count_ > 0) {
        const Edge edge = pending_[--pending_count_];
        if ((facets_[edge.from] >> edge.to & 1) != 0) continue;
        int third = 0;
        while (third == edge.from || third == edge.to) ++third;
        if (!add_facet(edge, third, false)) return false;
    }
    return std::all_of(facets_.begin(), facets_.begin() + count_, [](std::uint64_t known) { return known != 0; });
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

// Normals of planes as integers, each times some positive power of two, for the sign of det(Na, Nb, Nc). Distances do
// not matter and walls need no unit, so normals are narrower than the rows of rows.hpp.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/arithmetic.hpp"
#include "exact/double_double.hpp"
#include "exact/integer/rows.hpp"
#include "exact/integer/word_cross.hpp"

namespace votess::exact {

template <class N>
using Normal = std::array<N, 3>;

inline constexpr int word_bits = 60;  // with one bit more, for high + low

// One uninitialized T for each plane; on the heap for many planes or very wide numbers.
template <class T>
class Scratch {
public:
    explicit Scratch(std::size_t count) : count_(count) {
        if (count > capacity) more_.resize(count);
        data_ = count > capacity ? more_.data() : fixed_.data();
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    T& operator[](std::size_t i) { return data_[i]; }
    [[nodiscard]] std::span<const T> all() const { return {data_, count_}; }

private:
    static constexpr std::size_t capacity = sizeof(T) <= 128 ? 64 : 1;
    std::array<T, capacity> fixed_;
    std::vector<T> more_;
    std::size_t count_;
    T* data_;
};

inline int wall_sign(const Plane& wall) {
    return wall.kind == Plane::Kind::lower_wall ? -1 : 1;
}

// Writes all normals in one unit that leaves word_bits bits to the largest. Returns the exponent of the unit, or
// nothing when a difference is finer.
inline std::optional<int> word_normals(const Point& p, std::span<const Plane* const> planes,
                                       Scratch<WordVector>& normals) {
    double largest = 0;
    for (const Plane* plane : planes) {
        if (plane->is_oblique() || plane->is_reversed()) return std::nullopt;
        if (plane->is_bisector()) largest = std::max(largest, largest_difference(p, *plane));
    }
    // largest < 2^(exponent - 1022); the unit 2^(exponent - 1022 - word_bits) and its inverse must be normal.
    const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(largest) >> 52);
    if (largest != 0 && (exponent <= word_bits || exponent == 0x7ff)) return std::nullopt;
    const int unit_exponent = largest == 0 ? 0 : exponent - 1022 - word_bits;
    const double unit = power_of_two(unit_exponent), per_unit = power_of_two(-unit_exponent);
    bool whole = true;
    auto units = [&](double x) {
        const auto n = static_cast<std::int64_t>(x * per_unit);
        whole &= static_cast<double>(n) * unit == x;
        return n;
    };
    for (std::size_t i = 0; i < planes.size(); ++i) {
        const Plane& plane = *planes[i];
        auto& n = normals[i];
        if (plane.is_bisector()) {
            const Differences difference = differences(p, plane);
            if (!difference.exact) return std::nullopt;
            for (int k = 0; k < 3; ++k) {
                const auto [high, low] = difference.x[k];
                if (low != low) return std::nullopt;  // overflow
                n[k] = units(high) + (low != 0 ? units(low) : 0);
            }
        } else {
            n = {};
            n[plane.axis] = wall_sign(plane);
        }
        if (!whole) return std::nullopt;
    }
    return unit_exponent;
}

// Removes a common power of two from all normals except walls. Returns its exponent.
inline int reduce(std::span<const Plane* const> planes, Scratch<WordVector>& normals) {
    std::uint64_t any = 0;
    for (std::size_t i = 0; i < planes.size(); ++i)
        if (planes[i]->is_bisector())
            for (const std::int64_t x : normals[i]) any |= static_cast<std::uint64_t>(x);
    if (any == 0) return 0;
    const int zeros = std::countr_zero(any);
    for (std::size_t i = 0; i < planes.size(); ++i)
        if (planes[i]->is_bisector())
            for (std::int64_t& x : normals[i]) x >>= zeros;
    return zeros;
}

// Writes a normal in a unit of its own. Returns false when the coordinates span more than 124 bits.
inline bool wide_normal(const Point& p, const Plane& plane, Normal<WideInt<2>>& n) {
    n = {};
    if (plane.is_oblique()) {
        if (plane.kind == Plane::Kind::cell_wall && BitRange::of_vectors_in(plane).product_bits() > 124) return false;
        n = oblique_normal<2>(plane);
        return true;
    }
    if (!plane.is_bisector()) {
        n[plane.axis] = from_int128<2>(wall_sign(plane));
        return true;
    }
    BitRange range;
    range.add(p);
    range.add(plane);
    const int q = range.quantum();
    if (range.span() > 124) return false;
    const std::array seed{to_int128(p[0], q), to_int128(p[1], q), to_int128(p[2], q)};
    const Difference difference = int_difference(seed, plane, q);
    for (int k = 0; k < 3; ++k) n[k] = from_int128<2>(plane.is_reversed() ? -difference.n[k] : difference.n[k]);
    return true;
}

// Returns a normal at a width that holds any float64.
inline Normal<WideInt<widest>> widest_normal(const Point& p, const Plane& plane) {
    BitRange range;
    range.add(p);
    range.add(plane);
    return wide_row<widest>(p, plane, range.quantum()).n;
}

// Signs of N.(A x B), as WordCross has them.
template <int W>
class WideCross {
public:
    WideCross() = default;
    WideCross(const Normal<WideInt<W>>& a, const Normal<WideInt<W>>& b) : cross_(cross(a, b)) {}
    [[nodiscard]] int turn(const Normal<WideInt<W>>& n) const { return dot(n, cross_).sign(); }
    [[nodiscard]] bool is_zero() const { return cross_[0].zero() && cross_[1].zero() && cross_[2].zero(); }

private:
    Normal<WideInt<2 * W>> cross_;
};

inline WordCross cross_of(const WordVector& a, const WordVector& b) {
    return {a, b};
}
template <int W>
WideCross<W> cross_of(const Normal<WideInt<W>>& a, const Normal<WideInt<W>>& b) {
    return {a, b};
}

// Returns decide(normals), at a width that holds them and the determinants of any three.
template <class Decide>
auto decide_on_normals(const Point& p, std::span<const Plane* const> planes, Decide decide) {
    const std::size_t count = planes.size();
    {
        Scratch<WordVector> words(count);
        if (word_normals(p, planes, words)) {
            reduce(planes, words);
            return decide(words.all());
        }
    }
    Scratch<Normal<WideInt<2>>> n(count);
    bool fit = true;
    for (std::size_t i = 0; i < count && fit; ++i) fit = wide_normal(p, *planes[i], n[i]);
    if (fit) return decide(n.all());  // 3 * 2^(3 * 125 + 1) < 2^383
    Scratch<Normal<WideInt<widest>>> any(count);
    for (std::size_t i = 0; i < count; ++i) any[i] = widest_normal(p, *planes[i]);
    return decide(any.all());
}

}  // namespace votess::exact

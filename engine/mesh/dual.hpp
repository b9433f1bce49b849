// Shared by the readers of the dual of the mesh: original vertices for images, and seeds with shifts.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/at.hpp"
#include "result/result.hpp"

namespace votess {

using ByteShift = std::array<std::int8_t, 3>;

// A seed as it takes part in a simplex.
struct Member {
    std::int32_t seed;
    ByteShift shift;
    friend auto operator<=>(const Member&, const Member&) = default;
};

// The first image of a vertex stands for all.
inline std::size_t original(const detail::Result& r, std::int32_t vertex) {
    return at(r.vertex_image_of.empty() ? vertex : r.vertex_image_of[at(vertex)]);
}

// How many components the vectors of a result have.
inline std::size_t dimensions_of(const detail::Result& r) {
    return r.planar ? 2 : 3;
}

inline ByteShift shift_in(std::span<const std::int8_t> shifts, std::size_t i, int sign, std::size_t dimensions = 3) {
    ByteShift shift{};
    for (std::size_t k = 0; k < dimensions && !shifts.empty(); ++k)
        shift[k] = static_cast<std::int8_t>(sign * shifts[dimensions * i + k]);
    return shift;
}

inline ByteShift negative(const ByteShift& a) {
    return {static_cast<std::int8_t>(-a[0]), static_cast<std::int8_t>(-a[1]), static_cast<std::int8_t>(-a[2])};
}

inline ByteShift sum(const ByteShift& a, const ByteShift& b) {
    ByteShift s{};
    for (std::size_t k = 0; k < 3; ++k) s[k] = static_cast<std::int8_t>(a[k] + b[k]);
    return s;
}

// The facets of the polytopes of a dual.
struct PolytopeFacets {
    std::vector<std::size_t> facet_begin{0};   // by polytope, and the end of the last
    std::vector<std::size_t> corner_begin{0};  // by facet, and the end of the last
    std::vector<Member> corners;               // of a facet in turn, counterclockwise seen from outside
};
// Returns +1 when the members turn counterclockwise as seen by one that looks outward from its own place, see
// exact::orientation().
using TurnSeenFrom = std::function<int(const Member& from, const std::array<Member, 3>& around)>;
// result: the source of the dual, with all of its faces. turn: needed where cells reach infinity.
PolytopeFacets polytope_facets(const detail::Result& result, const Delaunay& dual, const TurnSeenFrom& turn = {});

}  // namespace votess

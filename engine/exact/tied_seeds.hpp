// The seeds around a vertex where more than four cells meet, as in most lattices. They lie on a sphere around it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "exact/predicate.hpp"

namespace votess::exact {

// The convex hull of such seeds, exact. Every seed is a corner of it, and two cells share a face that ends at the vertex
// if an edge of the hull joins their seeds. So one hull replaces corner_polygon() for each of the cells.
//
// Gift wrapping (Chand and Kapur, J. ACM 17(1), 1970). Differences are integers d below 2^62, for which
//     E = da.(db x dc),  A = the same over absolute values
// are computed in double. With u = 2^-53 and d rounded once, |error of E| <= 8 u A (see orientation.cpp). E is exact
// when A <= 2^52, as in vertex.hpp; that includes coplanar seeds in planes across an axis, where A = 0. Otherwise
// integers decide.
class TiedSeeds {
public:
    static constexpr std::size_t max_seeds = 64;

    // Takes p as seed 0, and the seeds of bisectors without powers as 1, 2, ... All of them lie on one sphere; 0, 1 and
    // 2 are corners of one facet. Returns false when they are too many, need more than 60 bits, or are not as stated.
    bool build(const Point& p, std::span<const Plane* const> bisectors);

    // Returns the seeds that edges of the hull join to this one. The order is that of corner_polygon(). Valid until the
    // next call.
    [[nodiscard]] std::span<const std::uint8_t> around(std::size_t seed);

private:
    struct Edge {
        std::uint8_t from, to;
    };
    struct Facet {  // through three seeds that turn counterclockwise, seen from outside
        int a, b, c;
        std::array<double, 3> normal, bound;
    };
    [[nodiscard]] std::array<double, 3> difference(int a, int b) const;
    [[nodiscard]] Facet through(int a, int b, int c) const;
    [[nodiscard]] int side(const Facet& facet, int seed) const;
    [[nodiscard]] int exact_side(const Facet& facet, int seed) const;
    bool add_facet(Edge edge, int third, bool is_facet);

    int count_ = 0;
    std::array<std::array<std::int64_t, 3>, max_seeds> at_;
    // Bit b of facets_[a]: the facet to the left of a -> b is known. next_[a][b]: the seed that follows b around a.
    std::array<std::uint64_t, max_seeds> facets_;
    std::array<std::array<std::uint8_t, max_seeds>, max_seeds> next_;
    std::array<Edge, 6 * max_seeds> pending_;  // known from their right side
    std::size_t pending_count_ = 0;
    std::array<std::uint8_t, max_seeds> around_;
};

}  // namespace votess::exact

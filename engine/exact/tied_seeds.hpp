// The seeds around a vertex where more than four cells meet, as in most lattices. They lie on a sphere around it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "exact/integer/vertex.hpp"
#include "exact/integer/word_cross.hpp"
#include "exact/predicate.hpp"

namespace votess::exact {

// The seeds of such a vertex, relative to one of them, and their convex hull, exact. Every seed is a corner of the
// hull, and two cells share a face that ends at the vertex if an edge of the hull joins their seeds. So one hull
// replaces corner_polygon() for each of the cells.
//
// Coordinates are integers below 2^61 in units of a power of two. The hull is found by gift wrapping (Chand and Kapur,
// J. ACM 17(1), 1970).
class TiedSeeds {
public:
    static constexpr std::size_t max_seeds = 64;

    // Begins with a seed and the vectors from it to three more, whose bisectors meet in the vertex. Returns false, and
    // is not usable, if these need more than 57 bits.
    bool begin(const Differences& a, const Differences& b, const Differences& c);
    [[nodiscard]] bool usable() const { return usable_; }
    void give_up() { usable_ = false; }

    // Returns the side of the bisector of another seed on which the vertex lies, as side_of_vertex() does, and adds the
    // seed if that is 0. Returns nothing, and is not usable any more, if there are too many or it needs too many bits.
    std::optional<int> side(const Differences& seed);

    // Finds the hull. The first, second and third seed must be corners of one facet. Returns false if they are not.
    bool wrap();
    // Returns the seeds that edges of the hull join to this one, in the order of corner_polygon(). Valid until the next
    // call.
    [[nodiscard]] std::span<const std::uint8_t> around(std::size_t seed);

private:
    struct Edge {
        std::uint8_t from, to;
    };
    [[nodiscard]] static IntRow row(const WordVector& n);
    [[nodiscard]] bool completes_rectangle(const WordVector& d) const;
    bool place(const Differences& seed, WordVector& out) const;
    [[nodiscard]] WordVector difference(std::size_t a, std::size_t b) const;
    bool wrap_parallelepiped();
    bool add_facet(Edge edge, std::size_t third, bool is_facet);

    bool usable_ = false, solved_ = false;
    IntVertex vertex_;  // of the first seed and the three, if solved_
    std::size_t count_ = 0;
    double unit_ = 1, per_unit_ = 1;
    std::array<WordVector, max_seeds> at_;
    // Bit b of facets_[a]: the facet to the left of a -> b is known. next_[a][b]: the seed that follows b around a.
    std::array<std::uint64_t, max_seeds> facets_;
    std::array<std::array<std::uint8_t, max_seeds>, max_seeds> next_;
    std::array<Edge, 6 * max_seeds> pending_;  // known from their right side
    std::size_t pending_count_ = 0;
    std::array<std::uint8_t, max_seeds> around_;
};

}  // namespace votess::exact

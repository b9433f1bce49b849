// The parts of all triangles in all cells.
//
// A triangle's parts are connected through sides on bisectors. So they are found from the owner of one vertex on: each
// such side leads to the part of the seed beyond it. This goes on in rounds over all triangles, each on all threads.
#pragma once

#include <cstdint>
#include <vector>

#include "core/thread_pool.hpp"
#include "surface/clipped_triangle.hpp"
#include "surface/surface.hpp"

namespace votess::surface {

// P parts, ascending by triangle, then seed. Some have no area.
struct Parts {
    std::vector<std::int32_t> triangles, seeds;  // P
    std::vector<std::uint8_t> without_area;      // P
    std::vector<std::int64_t> offsets;           // P+1, into the next three
    std::vector<Side> sides;
    std::vector<std::uint8_t> without_length;  // by side
    std::vector<std::int32_t> corners;         // vertices, see below; filled by number_corners()
    std::vector<std::size_t> of_triangle;      // T+1: the parts of each
    // Vertices 0 to V-1 are those of the mesh. The others are crossings of an edge, or of a triangle inside, with
    // bisectors. The part of lowest seed at a crossing, on an edge in its first triangle, has its place.
    std::vector<std::array<double, 2>> places;  // by vertex from V on, see ClippedTriangle::place()

    [[nodiscard]] std::size_t size() const { return triangles.size(); }
    [[nodiscard]] std::size_t begin(std::size_t p) const { return static_cast<std::size_t>(offsets[p]); }
    [[nodiscard]] std::size_t end(std::size_t p) const { return static_cast<std::size_t>(offsets[p + 1]); }
    // Returns the side that leads to a corner.
    [[nodiscard]] Side before(std::size_t p, std::size_t corner) const {
        return sides[corner == begin(p) ? end(p) - 1 : corner - 1];
    }
    // Returns the part of a triangle in a cell, which must exist.
    [[nodiscard]] std::size_t find(std::int32_t triangle, std::int32_t seed) const;
};

[[nodiscard]] Parts find_parts(const Surface& surface, ThreadPool& pool);

}  // namespace votess::surface

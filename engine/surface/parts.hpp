// The parts of all triangles in all cells.
//
// TriangleCells finds the parts of most triangles. Those of the others are connected through sides on bisectors, so
// ClippedTriangle finds them from the owner of one vertex on: each such side leads to the part of the seed beyond it.
// One thread finds those of a triangle; only where they are very many, all threads do, in rounds.
#pragma once

#include <cstdint>
#include <vector>

#include "core/thread_pool.hpp"
#include "surface/clipped_triangle.hpp"
#include "surface/surface.hpp"

namespace votess::surface {

// Integrals count from the seed.
struct Part {
    std::int32_t triangle, seed;
    std::uint32_t sides;  // their number
    bool has_area;
    double area, border;  // border: length on edges of one triangle
    Vector3 moment;       // filled from SurfaceWant::nearest on, as all that follows
    double energy;
    std::size_t begin;  // the first side
};

// P parts, ascending by triangle, then by seed. Some have no area.
struct Parts {
    std::vector<Part> list;
    // By side, and the corner that it leads from. Those of one part follow each other.
    std::vector<Side> sides;
    std::vector<std::uint8_t> without_length;
    std::vector<std::array<double, 2>> weights;  // of the triangle's second and third vertex
    std::vector<std::size_t> of_triangle;        // T+1: the parts of each
    // Vertices 0 to V-1 are those of the mesh. The others are crossings of an edge, or of a triangle inside, with
    // bisectors. The part of lowest seed at a crossing, on an edge in its first triangle, has its place.
    std::vector<std::int32_t> corners;  // vertices; filled by number_corners()
    struct Source {
        std::size_t part, corner;
    };
    std::vector<Source> sources;  // by vertex from V on
    // Returns the weight of the higher vertex at a crossing with an edge.
    [[nodiscard]] double share_on_edge(const Surface& surface, const Source& crossing) const;
    // Returns the weights of the second and third vertex at a corner, from the part that has its place.
    [[nodiscard]] std::array<double, 2> shared_weights(const Surface& surface, std::size_t p, std::size_t corner) const;

    [[nodiscard]] std::size_t size() const { return list.size(); }
    [[nodiscard]] std::size_t begin(std::size_t p) const { return list[p].begin; }
    [[nodiscard]] std::size_t end(std::size_t p) const { return list[p].begin + list[p].sides; }
    // Returns the side that leads to a corner.
    [[nodiscard]] Side before(std::size_t p, std::size_t corner) const {
        return sides[corner == begin(p) ? end(p) - 1 : corner - 1];
    }
    // Returns the part of a triangle in a cell, which must exist.
    [[nodiscard]] std::size_t find(std::int32_t triangle, std::int32_t seed) const;
};

// want: SurfaceWant::nearest or more.
[[nodiscard]] Parts find_parts(const Surface& surface, SurfaceWant want, ThreadPool& pool);

// Sums the areas and borders of the parts of each seed, scaled.
void find_areas(const Surface& surface, ThreadPool& pool, std::vector<double>& areas, std::vector<double>& borders);

// Makes equal corners of all parts one vertex.
void number_corners(Parts& parts, const Surface& surface, ThreadPool& pool);

}  // namespace votess::surface

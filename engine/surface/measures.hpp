// Measures of the parts of one cell.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/vector3.hpp"
#include "surface/parts.hpp"

namespace votess::surface {

// Scaled; one for each thread.
class CellOnSurface {
public:
    CellOnSurface(const Surface& surface, const Parts& parts, SurfaceWant want)
        : surface_(surface), parts_(parts), want_(want) {}

    struct Shared {
        std::int32_t seed;
        double length;
        std::int32_t curves, loops;
    };
    // own: the parts of the cell, ascending.
    void measure(std::int32_t seed, std::span<const std::size_t> own);

    double area, border, energy;
    Vector3 centroid, nearest;  // relative to the seed; NaN without an area
    // Filled from SurfaceWant::polygons on.
    std::int32_t pieces, euler;
    std::vector<std::int32_t> part_pieces;  // of each part, from 0 in the order of their first part
    std::vector<Shared> row;                // ascending; filled for SurfaceWant::all

private:
    // A side on a bisector: the seed beyond it, its part, and its corners.
    struct OnBisector {
        std::int32_t seed;
        std::size_t part;
        std::int32_t from, to;  // vertices
        double length;
        bool is_point;
    };
    void add_sides(std::size_t p);
    void find_nearest(std::span<const std::size_t> own);
    void find_pieces(std::span<const std::size_t> own);
    void find_row();
    // A triangle's first vertex, and the ways from there to the others.
    struct Frame {
        Vector3 first, second, third;
    };
    [[nodiscard]] Frame frame(std::size_t p) const;
    [[nodiscard]] std::size_t root(std::size_t i);

    const Surface& surface_;
    const Parts& parts_;
    SurfaceWant want_;
    std::int32_t seed_ = 0;
    std::vector<OnBisector> sides_;
    std::vector<std::pair<std::int32_t, std::size_t>> on_edges_;  // edges of the surface, and parts by their order
    std::vector<std::int32_t> vertices_;
    std::vector<std::size_t> joined_;  // a forest
    std::vector<std::pair<std::int32_t, std::size_t>> ends_;
    std::vector<Vector3> places_;
};

}  // namespace votess::surface

// The cells as the picture sees them: spans of a tessellation, and polygons cut out of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "picture/scene.hpp"

namespace votess::picture {

// Arrays as in Tessellation.
struct Mesh {
    std::span<const std::int64_t> indptr;
    std::span<const std::int32_t> indices;
    std::span<const std::int8_t> shifts;
    std::span<const std::int64_t> face_offsets;
    std::span<const std::int32_t> face_vertices;
    std::span<const double> vertices;
    // In the plane, else empty: the corners of each cell in turn. A face is an edge then, and z is 0.
    std::span<const std::int64_t> corner_begin{};
    std::span<const std::int32_t> corners{};
    std::span<const char> lines{};  // for each of face_vertices: 1 if the side from it is a line; empty: all are
    // The cells are polygons of the plane with holes: a face is an edge, and z is 0. Faces run ring after ring.
    bool rings = false;

    [[nodiscard]] std::size_t cells() const { return indptr.empty() ? 0 : indptr.size() - 1; }
    [[nodiscard]] std::size_t first_face(std::size_t cell) const { return static_cast<std::size_t>(indptr[cell]); }
    [[nodiscard]] std::size_t end_face(std::size_t cell) const { return static_cast<std::size_t>(indptr[cell + 1]); }
    [[nodiscard]] std::span<const std::int32_t> polygon(std::size_t face) const {
        const auto begin = static_cast<std::size_t>(face_offsets[face]);
        return face_vertices.subspan(begin, static_cast<std::size_t>(face_offsets[face + 1]) - begin);
    }
    [[nodiscard]] bool is_line(std::size_t face, std::size_t side) const {
        return lines.empty() || lines[static_cast<std::size_t>(face_offsets[face]) + side] != 0;
    }
    [[nodiscard]] Vec3 vertex(std::int32_t v) const {
        const double* p = &vertices[3 * static_cast<std::size_t>(v)];
        return {p[0], p[1], p[2]};
    }
    // Whether the cell behind the face is where the face is, and not an image elsewhere; false for walls.
    [[nodiscard]] bool joins(std::size_t face) const {
        if (indices[face] < 0) return false;
        return shifts.empty() || (shifts[3 * face] == 0 && shifts[3 * face + 1] == 0 && shifts[3 * face + 2] == 0);
    }
};

// A convex polygon. line[i]: the side from corner i to the next is an edge of a cell, to be drawn as a line.
struct Polygon {
    std::vector<Vec3> corners;
    std::vector<char> line;

    void clear() {
        corners.clear();
        line.clear();
    }
    void add(const Vec3& corner, bool side) {
        corners.push_back(corner);
        line.push_back(side);
    }
};

// The plane where coordinate `axis` has the value; its front is where `side` (1 or -1) times the coordinate is larger.
struct CutPlane {
    int axis = 0;
    double value = 0;
    double side = 1;

    [[nodiscard]] double height(const Vec3& p) const { return side * (p[static_cast<std::size_t>(axis)] - value); }
};

// Returns where the line from a to b meets the plane, which they lie on different sides of.
Vec3 crossing(const Vec3& a, const Vec3& b, const CutPlane& plane);

// The part of `in` in front of the plane, or with `behind` the rest. line: of the side along the plane.
void clip(const Polygon& in, const CutPlane& plane, bool behind, bool line, Polygon& out);

// The section of a cell by the plane, or a cell of the plane itself; no corners when they do not meet. Counterclockwise
// as seen from its front. A vertex lies on the same side for all cells, and crossed edges give all cells the same
// point: sections leave no gaps.
void section(const Mesh& mesh, std::size_t cell, const CutPlane& plane, Polygon& out);

}  // namespace votess::picture

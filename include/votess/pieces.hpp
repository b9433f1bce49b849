// Pieces of cells in a mesh, as closed triangle meshes.
//
//     options.mesh = {vertices, triangles};
//     const votess::Tessellation t = votess::tessellate(points, options);
//     const votess::Pieces p = votess::pieces(t);
//     p.indptr[i + 1] - p.indptr[i]                  // the number of pieces of cell i
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>
#include <votess/votess.hpp>

namespace votess {

struct PieceOptions {
    // Moves the planes of each cell inward by half of this length, so that pieces are this far apart. The surface of
    // the mesh stays. At least 0, finite.
    double gap = 0;
    unsigned threads = 0;            // as Options::threads
    ProgressCallback progress = {};  // as Options::progress
};

// The connected parts of cells in a mesh: P pieces. Closed surfaces bound each, one more for each cavity. Triangles are
// counterclockwise seen from outside. An edge occurs once in each direction, and more often in two cases: where more
// than two triangles of the mesh meet in it, and where ties leave triangles without an area. Pieces that touch in an
// edge or corner share no vertices.
//
// Where a surface intersects itself, pieces overlap. Where its winding number is negative, they are inside out.
// In the plane a piece is a polygon, with holes. It has edges instead of triangles, ring after ring, the outline first
// and the piece on the left. Vertices and centroids have two components, `triangles` two, `volumes` are areas, and a
// source on the mesh is one of its edges.
//
// Surfaces without a volume, except for rounding, are dropped. In a periodic domain a row has the pieces of all images
// of its cell. They lie in the mesh, and may be far from the seed.
struct Pieces {
    std::vector<std::int64_t> indptr;            // N+1: pieces of row i are indptr[i] to indptr[i + 1] - 1
    std::vector<std::int64_t> vertex_offsets;    // P+1: the first vertex of each piece
    std::vector<double> vertices;                // 3V, absolute; those of the mesh as given
    std::vector<std::int64_t> triangle_offsets;  // P+1: the first triangle of each piece
    std::vector<std::int32_t> triangles;         // 3T vertices, counted from the first of the piece
    std::vector<std::uint8_t> on_surface;        // T: 1 on the surface of the mesh, 0 on a plane between two cells
    std::vector<std::int32_t> sources;           // T: the triangle of the mesh; or the seed beyond the plane
    std::vector<double> volumes;                 // P, length unit cubed
    std::vector<double> centroids;               // 3P, absolute

    [[nodiscard]] std::size_t size() const noexcept { return volumes.size(); }  // P
};

// Returns the pieces of all rows of a tessellation with Options::mesh. Without a gap the volumes of a cell's pieces sum
// to the cell's to a relative 1e-12. Places on the surface count as outside, so that a piece is connected through its
// inside. Where a plane between two cells lies in the surface in part, triangles of pieces may name the seed there
// instead of the triangle of the mesh. The tessellation keeps what this needs: the mesh, the seeds and all their
// neighbors, about 100 bytes a seed. Throws invalid_argument for a tessellation without a mesh, and for a bad gap.
[[nodiscard]] VOTESS_API Pieces pieces(const Tessellation& tessellation, const PieceOptions& options = {});

}  // namespace votess

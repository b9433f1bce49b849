// The restricted Voronoi diagram: the parts of cells on a triangle surface, which need be neither closed nor oriented
// alike. Its dual, the restricted Delaunay triangulation, is a triangle mesh of the seeds.
//
//     const votess::SurfaceCells cells = votess::surface_cells(points, {vertices, triangles});
//     cells.areas[i]                    // of the part of cell i
//     cells.dual                        // triangles of seeds
//
// Cells are those of all seeds in whole space, or power cells with weights. Signs are exact, so that the parts tile the
// surface. A place as near to several seeds belongs to the one of lowest index: its weight counts as larger by less
// than any number. So a cell that only touches the surface may have a part without area. Triangles without area are
// skipped, and no part is connected through them. The surface may intersect itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
#include <votess/votess.hpp>

namespace votess {

struct SurfaceOptions {
    std::span<const double> weights = {};  // N, length unit squared, as Options::weights; empty: none
    unsigned threads = 0;                  // as Options::threads
    ProgressCallback progress = {};        // as Options::progress
};

// N cells on a surface of V vertices and T triangles.
struct VOTESS_API SurfaceCells {
    std::vector<double> areas;          // N; they sum to the area of the surface
    std::vector<double> centroids;      // 3N, of the parts; NaN for a part without area
    std::vector<double> nearest;        // 3N: the place of the part nearest to its centroid; NaN likewise
    std::vector<double> energies;       // N: the integral of |x - p|^2 over the part
    std::vector<double> borders;        // N: length on edges of one triangle
    std::vector<std::int32_t> pieces;   // N: connected parts, joined through edges of the surface
    std::vector<std::int32_t> euler;    // N: Euler's characteristic of the part: 1 for a disk
    std::vector<std::int64_t> indptr;   // N+1: offsets into the next three
    std::vector<std::int32_t> indices;  // ascending: seeds with which a cell shares a positive length
    std::vector<double> lengths;        // that length, equal for both cells
    std::vector<std::int32_t> curves;   // connected curves of which it consists
    std::vector<std::int32_t> loops;    // those among them that are closed
    // P polygons, one for each triangle and cell that share an area. They ascend by triangle, then seed. Corners run as
    // those of the triangle, and are shared: equal places of neighbors are one vertex. Vertices 0 to V - 1 are those of
    // the surface as given.
    std::vector<std::int32_t> polygon_triangles;  // P
    std::vector<std::int32_t> polygon_seeds;      // P
    std::vector<double> polygon_areas;            // P
    std::vector<std::int64_t> polygon_offsets;    // P+1: offsets into the next two
    std::vector<std::int32_t> corners;            // vertices
    // The side from each corner: the seed beyond it, or -1 - k on the triangle's edge from its corner k.
    std::vector<std::int32_t> beyond;
    std::vector<double> vertices;  // 3 times their number
    // Restricted Delaunay triangles, each once, ascending. A triangle turns as the surface does where the three cells
    // first meet on it.
    std::vector<std::int32_t> dual;         // 3 times their number: seeds, the lowest first
    std::vector<std::int32_t> dual_counts;  // places where these cells meet

    [[nodiscard]] std::size_t size() const noexcept { return areas.size(); }  // N
    // Returns the seeds at which the dual may differ from the surface (Edelsbrunner, Shah: Triangulating topological
    // spaces, 1997). Their part is no disk, or shares several curves or a closed one with a neighbor, or meets
    // two neighbors at several places. More seeds near them mend this. Seeds without a part are not among them.
    [[nodiscard]] std::vector<std::int32_t> faults() const;
};

// Returns the parts of the cells of N points on a surface. TriangleMesh::merge and tolerance apply. Areas sum to that
// of the surface, relative 1e-13. The same on any number of threads. Throws invalid_argument for bad shapes, numbers
// that are not finite, no points, and a surface without area; and Error as tessellate() does.
[[nodiscard]] VOTESS_API SurfaceCells surface_cells(std::span<const double> points, const TriangleMesh& surface,
                                                    const SurfaceOptions& options = {});

}  // namespace votess

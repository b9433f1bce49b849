// The restricted Voronoi diagram: the parts of cells on a triangle surface, which need be neither closed nor oriented
// alike. Its dual, the restricted Delaunay triangulation, is a triangle mesh of the seeds.
//
//     const votess::SurfaceCells cells = votess::surface_cells(points, {vertices, triangles});
//     cells.areas[i]                    // of the part of cell i
//     cells.dual                        // triangles of seeds
//     votess::remesh({vertices, triangles}, 5000).triangles  // about 10,000 well-shaped ones
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

// Which arrays of SurfaceCells to make. Each requests those of the former too; the others stay empty.
enum class SurfaceWant : std::int32_t {
    areas = 1,     // areas, borders
    nearest = 2,   // centroids, nearest, energies
    polygons = 3,  // pieces, euler, polygon_*, corners, beyond, vertices
    all = 4,       // rows and duals
};

struct SurfaceOptions {
    std::span<const double> weights = {};  // N, length unit squared, as Options::weights; empty: none
    SurfaceWant want = SurfaceWant::all;
    unsigned threads = 0;            // as Options::threads
    ProgressCallback progress = {};  // as Options::progress
};

// N cells on a surface of V vertices and T triangles.
struct VOTESS_API SurfaceCells {
    std::vector<double> areas;      // N; they sum to the area of the surface
    std::vector<double> centroids;  // 3N, of the parts; NaN for a part without area
    std::vector<double> nearest;    // 3N: the place of the part nearest to its centroid; NaN likewise
    // N: the integral of |x - p|^2 over the part. Areas and energies beyond double are infinite or 0, as for
    // coordinates of 1e200.
    std::vector<double> energies;
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
    std::vector<std::int32_t> polygon_pieces;     // P: the connected part, numbered over all cells in their order
    std::vector<std::int64_t> polygon_offsets;    // P+1: offsets into the next two
    std::vector<std::int32_t> corners;            // vertices
    // The side from each corner: the seed beyond it, or -1 - k on the triangle's edge from its corner k.
    std::vector<std::int32_t> beyond;
    std::vector<double> vertices;  // 3 times their number
    // Restricted Delaunay triangles, each once, ascending. A triangle turns as the surface does where the three cells
    // first meet on it.
    std::vector<std::int32_t> dual;         // 3 times their number: seeds, the lowest first
    std::vector<std::int32_t> dual_counts;  // places where these cells meet
    // The same with each connected part as a vertex of its own, by the numbers of polygon_pieces. Where cells lie on
    // both sides of a thin plate, the dual has both sides too.
    std::vector<std::int32_t> piece_dual;
    std::vector<std::int32_t> piece_dual_counts;

    [[nodiscard]] std::size_t size() const noexcept { return areas.size(); }  // N
    // Returns the seeds at which the dual may differ from the surface (Edelsbrunner, Shah: Triangulating topological
    // spaces, 1997). Their part is not a disk, or shares several curves or a closed one with a neighbor, or meets
    // two neighbors at several places. More seeds near them mend this. Seeds without a part are not among them. Throws
    // invalid_argument unless all arrays were wanted.
    [[nodiscard]] std::vector<std::int32_t> faults() const;
};

// Calls visit(name, array, components) for each array; 3 components: a row has three elements.
template <class Visit>
void for_surface_arrays(const SurfaceCells& cells, Visit&& visit) {
    visit("areas", cells.areas, 1);
    visit("centroids", cells.centroids, 3);
    visit("nearest", cells.nearest, 3);
    visit("energies", cells.energies, 1);
    visit("borders", cells.borders, 1);
    visit("pieces", cells.pieces, 1);
    visit("euler", cells.euler, 1);
    visit("indptr", cells.indptr, 1);
    visit("indices", cells.indices, 1);
    visit("lengths", cells.lengths, 1);
    visit("curves", cells.curves, 1);
    visit("loops", cells.loops, 1);
    visit("polygon_triangles", cells.polygon_triangles, 1);
    visit("polygon_seeds", cells.polygon_seeds, 1);
    visit("polygon_areas", cells.polygon_areas, 1);
    visit("polygon_pieces", cells.polygon_pieces, 1);
    visit("polygon_offsets", cells.polygon_offsets, 1);
    visit("corners", cells.corners, 1);
    visit("beyond", cells.beyond, 1);
    visit("vertices", cells.vertices, 3);
    visit("dual", cells.dual, 3);
    visit("dual_counts", cells.dual_counts, 1);
    visit("piece_dual", cells.piece_dual, 3);
    visit("piece_dual_counts", cells.piece_dual_counts, 1);
}

// Returns the parts of the cells of N points on a surface. TriangleMesh::merge and tolerance apply. Areas sum to that
// of the surface, relative 1e-13. The same on any number of threads. Throws invalid_argument for bad shapes, numbers
// that are not finite, no points, and a surface without area; and Error as tessellate() does.
[[nodiscard]] VOTESS_API SurfaceCells surface_cells(std::span<const double> points, const TriangleMesh& surface,
                                                    const SurfaceOptions& options = {});

struct SurfaceLloydOptions {
    unsigned steps = 100;                      // the maximum
    std::span<const std::uint8_t> fixed = {};  // N, 1 for a seed that does not move; empty: all move
    double tolerance = 0;  // stop when no seed moved farther, in units of the square root of the mean area of a cell
    unsigned threads = 0;  // as Options::threads
    ProgressCallback progress = {};  // as Options::progress
};

// The outcome of S steps. S is smaller than requested if the tolerance was reached.
struct VOTESS_API SurfaceRelaxation {
    std::vector<double> points;    // 3N, on the surface
    std::vector<double> energies;  // S+1: the sum of SurfaceCells::energies before the first step and after each
    std::vector<double> moved;     // S: the largest move in each step, in units of the tolerance
    SurfaceCells cells;            // of `points`
};

// Moves each seed to SurfaceCells::nearest, step by step, so that seeds spread evenly over the surface. Those without a
// part stay. Throws as surface_cells(); and invalid_argument for `fixed` of another length and a tolerance that is
// negative or not finite.
[[nodiscard]] VOTESS_API SurfaceRelaxation lloyd_on_surface(std::span<const double> points, const TriangleMesh& surface,
                                                            const SurfaceLloydOptions& options = {});

// Returns `count` random places, uniform by area: 3 * count numbers, one place in each stretch of equal area. The same
// on every machine. Throws invalid_argument as surface_cells().
[[nodiscard]] VOTESS_API std::vector<double> sample_surface(const TriangleMesh& surface, std::size_t count,
                                                            std::uint64_t rng_seed = 1);

struct RemeshOptions {
    unsigned steps = 16;  // of the relaxation
    // Degrees, above 0: an edge at which the surface turns by more is sharp, and a sharp edge has a corner where it
    // turns by more. 180: keep borders alone.
    double sharp = 40;
    std::uint64_t rng_seed = 1;      // of the first places
    unsigned threads = 0;            // as Options::threads
    ProgressCallback progress = {};  // as Options::progress
};

// A mesh of W vertices and D triangles. Figures are 0 without triangles, except the distance, which is infinite.
struct VOTESS_API Remesh {
    std::vector<double> vertices;         // 3W, on the surface
    std::vector<std::int32_t> triangles;  // 3D vertices, turned as the surface; the lowest first
    std::vector<double> points;           // 3M seeds
    // Of these; vertex k is their connected part k. Further vertices lie in parts that were split.
    SurfaceCells cells;
    std::vector<double> energies;  // before the first step of the relaxation, and after each
    double min_angle = 0;          // degrees, of all triangles
    double mean_min_angle = 0;     // degrees: the mean of the smallest angle of each triangle
    // The largest distance found between the two meshes: from corners of the polygons of `cells`, and from the middles
    // of the triangles and of their sides.
    double distance = 0;
    std::size_t border_edges = 0;   // of one triangle
    std::size_t crowded_edges = 0;  // of more than two
    // Seeds at which the mesh may differ from the surface: a part is not a disk, the triangles around it do not fit
    // together, or they miss a border or a corner in it. More vertices mend this.
    std::vector<std::int32_t> faults;
};

// Returns a mesh of well-shaped triangles with about `count` vertices: exactly so many, unless parts of the surface are
// thinner than the triangles are long, or it has more corners. Random places are relaxed as by lloyd_on_surface(), with
// longer steps, and joined by the dual of connected parts. Seeds whose cells hold a stretch of a border or of a sharp
// edge move along it, and one goes to each of their corners. Where the triangles would miss a corner or a border, as in
// a sharp tip, seeds are added there. So the mesh ends where the surface does. Sharp edges closer to each other than
// the triangles are long may share vertices. Where cells fall into several parts, fewer seeds make the same number of
// vertices. Where the mesh would differ from the surface, as around thin bars, seeds are added; in all at most `count`.
// Parts that still do not fit together are split, into at most 4 `count` more, each with a vertex of its own: so the
// mesh is closed, and has the handles of the surface, where that is a manifold. `faults` has what is left. Flat
// triangles are mended by flips of their longest edge. The same on any number of threads. Throws as surface_cells();
// and invalid_argument for a count of 0 or of more than 2^28, and for a bad angle.
[[nodiscard]] VOTESS_API Remesh remesh(const TriangleMesh& surface, std::size_t count,
                                       const RemeshOptions& options = {});

}  // namespace votess

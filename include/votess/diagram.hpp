// Queries of fixed seeds: the cell that holds a point, the cell that a new point would have, the cells along a ray,
// fields between the seeds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "votess/votess.hpp"

namespace votess {

namespace detail {
struct DiagramState;
}

struct ProbeOptions {
    Want want;                               // arrays of the probes' cells
    bool list_walls = false;                 // as Options::list_walls
    std::span<const double> weights, radii;  // Q, of the probes in a power diagram, as in Options; empty: weight 0
    ProgressCallback progress = {};          // as Options::progress
};

// How to weigh the natural neighbors of a query. Both methods reproduce linear fields away from the walls.
enum class NaturalMethod : std::int32_t {
    // The share of the query's cell that each seed had before (Sibson 1980). Smooth except at the seeds. In a power
    // diagram a query may leave a seed no cell; it then takes the whole cell.
    sibson = 0,
    laplace = 1,  // the area of the face with a neighbor over its distance, over the sum of these ratios
};

struct NaturalOptions {
    NaturalMethod method = NaturalMethod::sibson;
    // Cells end at walls, as if mirror images of the seeds with their values lay behind. Weights still sum to 1, but
    // linear fields are not reproduced where the query's cell has a wall. False: no coordinates there.
    bool at_walls = true;
    bool gradients = false;           // of the weights; only for sibson
    std::span<const double> weights;  // Q, of the queries in a power diagram; empty: 0
    ProgressCallback progress = {};   // as Options::progress
};
// Row q starts at indptr[q]: all seeds with a share of query q, ascending, and their weights. Weights are positive,
// within 1e-12 of the true ones, and sum to 1 within 1e-13; gradients have fewer digits. A query on a seed has that
// seed alone. A row is empty
//   - outside the domain, and where there are no seeds; in periodic domains these are refused
//   - in all of space where the query's cell reaches infinity: outside of the convex hull of the seeds
//   - without at_walls where the query's cell has a wall
//   - where the seeds of a power diagram leave the query no cell
struct NaturalCoordinates {
    std::vector<std::int64_t> indptr;   // Q+1
    std::vector<std::int32_t> indices;  // indptr[Q] seeds
    std::vector<double> weights;        // indptr[Q]
    std::vector<double> gradients;      // (indptr[Q], d), of the weights, per length unit; NaN on a seed
};
struct Interpolated {
    std::vector<double> values;     // (Q, m); NaN where there are no coordinates
    std::vector<double> gradients;  // (Q, m, d), per length unit; NaN there and on seeds; empty unless requested
};

enum class GridMethod : std::int32_t {
    // The average over the grid cell of the field that is values[i] in the cell of seed i. The grid cuts the cells;
    // nothing is sampled. The field is 0 outside the domain. The grid times the volume of a grid cell sums to the sum
    // of values times volumes, to a relative 1e-12 of their magnitudes.
    mean = 0,
    // The average over the grid cell of the Delaunay tessellation field estimator (Schaap, van de Weygaert: Continuous
    // fields and density reconstruction, A&A 363, 2000). values are masses. The density at seed i is 4 values[i] / W,
    // where W is the volume of the tetrahedra of delaunay() around it. The density is linear in each tetrahedron, and 0
    // outside of all. The average is exact: the grid times the volume of a grid cell sums to the total mass, to a
    // relative 1e-12, however flat or small the tetrahedra are.
    //
    // Tetrahedra of seeds outside (Outside::keep) may reach beyond the box. Each grid cell has the average over itself,
    // so mass beyond the box is not in the grid. Oblique walls do not end the field.
    //
    // A polytope is divided into tetrahedra from its center and the centers of its facets, where the density is the
    // mean of the corners. W is then four times the integral of the field that is 1 at the seed and 0 at the others. So
    // the result does not depend on the order of the seeds.
    //
    // Duplicates add their mass to the seed that keeps the cell. A seed in no tetrahedron has no density, and to_grid()
    // counts it: a dropped seed, one without a cell, or one at the rim of a domain that is not periodic. Throws
    // invalid_argument where float64 cannot hold the average.
    dtfe = 1,
    // values[i] of the cell that holds the center of the grid cell, as by Diagram::locate(); 0 outside the domain.
    nearest = 2,
    // The field at that center as by Diagram::interpolate() with default options; 0 outside the domain, NaN where seeds
    // of a power diagram leave the center no cell.
    sibson = 3,
};

// The grid divides the box of the domain along x, y and z, or a triclinic box along its edges a, b and c. Grid cell
// (i, j, k) is element (i * ny + j) * nz + k of an array of the shape (nx, ny, nz). In two dimensions nz is 1, and
// dtfe is linear in triangles.
struct GridOptions {
    std::array<std::size_t, 3> shape{};  // nx, ny, nz: 1 to 2^20 each
    GridMethod method = GridMethod::mean;
    std::size_t columns = 1;  // m, number of values of each seed
    // 0, 1 or 2: sums along this axis or edge, times the length of a grid cell along it, so that densities become
    // column densities. The grid then has length 1 there. `mean` and `dtfe` integrate exactly for any shape.
    std::optional<int> project = std::nullopt;
    ProgressCallback progress = {};  // as Options::progress
};

struct TraceOptions {
    bool middles = false;            // compute RayCells::middles: 8 d bytes a cell passed
    ProgressCallback progress = {};  // as Options::progress
};

// Row r starts at offsets[r]: the cells that ray r passes, in order, and its length in each. A periodic domain repeats,
// so a seed may be there several times.
struct VOTESS_API RayCells {
    std::vector<std::int64_t> offsets;  // R+1
    std::vector<std::int32_t> seeds;    // offsets[R]
    std::vector<double> lengths;        // offsets[R], at least 0
    // (offsets[R], d) with TraceOptions::middles: the middle of each piece of the ray, minus the place of the seed or
    // image whose cell it is. Errors stay below 1e-12 of the largest coordinate on the way.
    std::vector<double> middles;
    bool planar = false;  // d = 2

    // Returns the integral along each ray of the field that is `value + gradient . (x - seed)` in each cell. values: N.
    // gradients: (N, d), or none where the field is constant in cells; these need middles. Throws invalid_argument for
    // fewer values than the seeds need, for gradients of another size, and without middles.
    [[nodiscard]] std::vector<double> integrate(std::span<const double> values,
                                                std::span<const double> gradients = {}) const;
};

// Vectors have d components: 3, or 2 with Options::planar.
//
// Seeds, sorted once for searching; no cell is built. A shared handle to immutable data, cheap to copy. Many threads
// may query one Diagram; the calls run one after the other, each on options.threads threads of the CPU.
//
// A progress callback that returns false stops its call, also while the call waits for another one. The call then
// throws `cancelled` and changes nothing. A callback that queries the Diagram that calls it gets `invalid_use`.
class VOTESS_API Diagram {
public:
    Diagram();  // without seeds
    // points: as for tessellate(); copied. Without box, cell and walls the domain is all of space, or of the plane. The
    // grid of to_grid() covers the default box of tessellate() along infinite sides and edges that are 0. Uses these
    // options: the domain, planar, weights, radii, outside, duplicates, threads, grid_resolution, instructions and
    // progress. Throws Error as tessellate() does; `unsupported` for a device other than "cpu" and "auto";
    // invalid_argument with min_face or min_area.
    //
    // Options::mesh cuts the domain. Its surface is inside; outside there are no answers, and grids are 0. Inside,
    // natural_neighbors() and interpolate() answer as without the mesh. trace() gives the parts of rays inside: which
    // triangles a ray passes is exact, and times are rounded. A ray in the surface counts as moved off it by less than
    // any distance. One may begin outside of the mesh, though not of a box. probe() gives the part inside of the cell
    // that a seed there would have, without vertices, faces, counts and radii. to_grid() refuses `dtfe`.
    explicit Diagram(std::span<const double> points, const Options& options = {});

    [[nodiscard]] std::size_t size() const noexcept;  // N, number of seeds
    [[nodiscard]] bool planar() const noexcept;       // whether d is 2
    // Returns, for each query, the seed whose cell holds it: exactly the one with the least |x - p|^2 - w. On a face,
    // edge or vertex the lowest seed is returned; of duplicates the seed that keeps the cell; -1 outside the domain
    // (walls are inside) and without seeds. queries: (Q, d), finite; a periodic domain wraps them without rounding.
    // Throws invalid_argument; `unsupported` for a query too small beside the box for one scale.
    [[nodiscard]] std::vector<std::int32_t> locate(std::span<const double> queries,
                                                   const ProgressCallback& progress = {}) const;
    // Returns the cells along R rays, which begin at `origins`. A ray ends after its length, or at a wall of the
    // domain. One that begins outside the domain has no cells. origins, directions: (R, d), finite; only the direction
    // of a vector matters. lengths: R, at least 0; infinity is allowed where a wall ends the ray.
    //
    // Cells and their order are exact: those of the true diagram along the true ray. Only the length is rounded, when
    // it is divided by that of the direction. A ray through an edge or a vertex passes the cells where it has a length,
    // and each once. In a common face or edge of cells it passes the lowest seed that has a cell. A length may be
    // rounded to 0. The lengths of a ray sum to its length inside the domain to a relative 1e-13.
    //
    // The first call computes the neighbors of all cells and stores them for later calls: 260 bytes a seed. Throws as
    // locate(); invalid_argument for a bad direction or length, and for an infinite ray without a wall in its way;
    // `unsupported` for directions whose components no common scale holds, for a ray through more than 2^24 cells, and
    // beyond 500 million periods.
    [[nodiscard]] RayCells trace(std::span<const double> origins, std::span<const double> directions,
                                 std::span<const double> lengths, const TraceOptions& options = {}) const;
    // Returns Q cells: the cell that each query would have if it alone were added to the seeds. Rows are bit for bit
    // those of seed N in tessellate() of the seeds and the query; volumes and areas agree to 1e-10. queries: as for
    // locate().
    //
    // Rows name seeds. N is the query itself, which may be its own neighbor in a small periodic domain. Shifts count
    // from where the query lies inside the domain. status(): `outside` beyond the box and its walls, also where seeds
    // there are kept; `duplicate` at the place of a seed, whose own cell is the answer, see duplicate_of(); `empty`
    // where the seeds leave no cell, or at the place of a heavier seed. A probe on a seed of less weight has its cell.
    //
    // The cells overlap and share no vertices, and stats().volume_sum is not the volume of the domain. So delaunay(),
    // verify() and render() refuse the result; wrapped_points() takes the queries. Throws as locate(); invalid_argument
    // for weights without a power diagram.
    [[nodiscard]] Tessellation probe(std::span<const double> queries, const ProbeOptions& options = {}) const;
    // Returns natural-neighbor coordinates of the queries, which are as for locate(). Throws as locate();
    // invalid_argument for gradients with `laplace`; `unsupported` where a periodic box has so few seeds that a cell
    // meets its own image.
    //
    // The first call with `sibson` in a box and at least N / 2 queries stores all Voronoi vertices for later calls: 430
    // bytes a seed, 1.2 KB while they are found. It makes queries two to three times faster.
    [[nodiscard]] NaturalCoordinates natural_neighbors(std::span<const double> queries,
                                                       const NaturalOptions& options = {}) const;
    // Returns the sums of values, weighted by these coordinates. values: (N, m) with m = components. Throws as
    // natural_neighbors(); invalid_argument for values of another shape.
    [[nodiscard]] Interpolated interpolate(std::span<const double> values, std::size_t components,
                                           std::span<const double> queries, const NaturalOptions& options = {}) const;
    // Fills a grid from the seeds' values. values: (N, m), row i of seed i. grid: (nx, ny, nz, m) in C order, in the
    // unit of values, for `dtfe` per unit of volume. Returns the number of seeds whose mass `dtfe` could not place; 0
    // for other methods.
    //
    // NaN and infinity propagate to the grid cells they affect. Rows of seeds without a cell are ignored, except
    // duplicates in `dtfe`. Results do not depend on the number of threads, except the last digits of `sibson`. `mean`
    // and `dtfe` need 1.2 KB a seed meanwhile. Throws invalid_argument for arrays or options that do not fit; as
    // tessellate(); with `nearest` and `sibson` as locate() and interpolate().
    std::size_t to_grid(std::span<const double> values, const GridOptions& options, std::span<double> grid) const;
    // Returns a result without rows in the domain that grids divide, which has ends.
    [[nodiscard]] Tessellation grid_domain() const;

private:
    std::shared_ptr<detail::DiagramState> state_;
};

}  // namespace votess

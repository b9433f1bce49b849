// Seeds that stay, asked many times: which cell holds a point; what cell a point would have; fields of what they carry.
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

// What to find of the cells of probes.
struct ProbeOptions {
    Want want;
    bool list_walls = false;                 // as Options::list_walls
    std::span<const double> weights, radii;  // Q, of the probes in a power diagram, as in Options; empty: weight 0
    ProgressCallback progress = {};          // as Options::progress
};

// Sibson's: the share of a query's cell that each seed had before; in a power diagram the query may bury seeds, whose
// whole cell it takes. Laplace's: the area of the face with a neighbor over its distance, over the sum of these. Both
// reproduce linear fields away from the walls; Sibson's are smooth but at the seeds.
enum class NaturalMethod : std::int32_t { sibson = 0, laplace = 1 };

struct NaturalOptions {
    NaturalMethod method = NaturalMethod::sibson;
    // Cells end at walls, as if the seeds had mirror images behind, with their values: weights still sum to 1, but
    // linear fields are not reproduced where the cell of a query has a wall. False: there are no coordinates there.
    bool at_walls = true;
    bool gradients = false;           // Sibson's only
    std::span<const double> weights;  // Q, of the queries in a power diagram; empty: 0
    ProgressCallback progress = {};   // as Options::progress
};
// Row q, from indptr[q] on: the natural neighbors of query q, ascending, and their weights. All seeds with a share are
// there. Weights are positive, within 1e-12 of the true ones, and sum to 1 within 1e-13. Gradients have fewer digits. A
// query on a seed has that one alone. Rows are empty outside of the domain, where there are no seeds, where a cell has
// a wall unless at_walls, and where seeds of a power diagram leave a query no cell.
struct NaturalCoordinates {
    std::vector<std::int64_t> indptr;   // Q+1
    std::vector<std::int32_t> indices;  // seeds
    std::vector<double> weights;
    std::vector<double> gradients;  // three for each entry, per length unit: of its weight; NaN on a seed
};
struct Interpolated {
    std::vector<double> values;     // (Q, m); NaN where there are no coordinates
    std::vector<double> gradients;  // (Q, m, 3), per length unit; NaN there and on seeds; empty unless wanted
};

// What a grid cell is given.
enum class GridMethod : std::int32_t {
    // The field that is values[i] in the cell of seed i, averaged over the volume of each grid cell: cells are cut by
    // the grid, nothing is sampled. Where the domain is not, beyond walls, the field is 0: a grid cell that walls cut
    // holds the part inside, and of values that are 1 the share of its volume that lies inside. So the grid times the
    // volume of a grid cell sums to that of values times volumes, to a relative 1e-12 of their magnitudes.
    mean = 0,
    // The Delaunay tessellation field estimator (Schaap, van de Weygaert: Continuous fields and density reconstruction,
    // A&A 363, 2000). values are masses. The density at seed i is 4 values[i] / W, where W is the volume of the
    // tetrahedra of delaunay() around it; it is linear in each of them, and 0 outside of all. A polytope is cut into
    // tetrahedra from its center, and its facets from theirs, where the density is the mean of that at the corners: so
    // the order of the seeds does not matter, and W becomes four times the integral of what is 1 at the seed and 0 at
    // the others. The average over a grid cell is exact: the grid times the volume of a grid cell sums to all mass, to
    // a relative 1e-12, however flat or small the tetrahedra are. Duplicates add their mass to the seed that has the
    // cell. A seed in no tetrahedron has no density: one that was dropped, that has no cell, or that lies at the rim of
    // a domain that is not periodic, where delaunay() lacks simplices. to_grid() counts them. It throws
    // invalid_argument where the average over a grid cell is a number that float64 cannot hold.
    dtfe = 1,
    // values[i] of the cell that holds the center of the grid cell, as Diagram::locate() says; 0 outside of the domain.
    nearest = 2,
    // The field at that center by Sibson's coordinates, as Diagram::interpolate() finds it with its defaults; 0 outside
    // of the domain, NaN where seeds of a power diagram leave a query no cell.
    sibson = 3,
};

// A grid whose cells divide the box of the domain along x, y and z, and a triclinic box along its edges a, b and c.
// Grid cell (i, j, k) is element (i * ny + j) * nz + k of an array of the shape (nx, ny, nz).
struct GridOptions {
    std::array<std::size_t, 3> shape{};  // nx, ny, nz: 1 to 2^20 each
    GridMethod method = GridMethod::mean;
    std::size_t columns = 1;  // m, numbers that each seed has
    // 0, 1 or 2: sum along this axis or edge, times the length of a grid cell along it. That makes densities column
    // densities, of a grid whose shape is 1 there. `mean` and `dtfe` integrate exactly, whatever the shape was.
    std::optional<int> project = std::nullopt;
    ProgressCallback progress = {};  // as Options::progress
};

// Seeds, sorted and searched once; no cell is built. A shared handle to what never changes, cheap to copy: any number
// of threads may ask one at the same time. Queries run on the CPU, on options.threads threads, one call after the
// other. Each takes a progress callback, as tessellate() does, and throws `cancelled` when that returns false, also
// while it waits for another call. A call that was stopped changes nothing. A callback may not ask the Diagram that
// calls it, which throws `invalid_use`.
class VOTESS_API Diagram {
public:
    Diagram();  // of no seeds
    // points: as for tessellate(); copied. Of the options those of the domain, weights, radii, outside, duplicates,
    // threads, grid_resolution, instructions and progress count. Throws Error as tessellate() does; `unsupported` for a
    // device other than "cpu" and "auto"; invalid_argument with min_face or min_area, for the cells are whole.
    explicit Diagram(std::span<const double> points, const Options& options = {});

    [[nodiscard]] std::size_t size() const noexcept;  // number of seeds, N
    // queries: 3Q coordinates, finite; in a periodic domain anywhere, they are wrapped without rounding. Returns Q
    // seeds: the one whose cell holds the query, so that |x - p|^2 - w is least, exactly; of several on a face, edge or
    // vertex the lowest; -1 outside of the domain, and where there are no seeds. On a wall is inside. Of seeds at one
    // place the one that has the cell is named, see Options::duplicates. Throws invalid_argument, and `unsupported` for
    // a query too small beside the box to be represented at one scale.
    [[nodiscard]] std::vector<std::int32_t> locate(std::span<const double> queries,
                                                   const ProgressCallback& progress = {}) const;
    // The cell that each query would have if it alone were added to the seeds: bit for bit the row that tessellate()
    // finds for seed N of those and the query, volumes and the like to 1e-10. queries: as for locate(). The result has
    // Q cells, in the order of the queries, whose rows name seeds; N is the query itself, which in a small periodic
    // domain may be its own neighbor. Shifts count from where the query lies inside the domain. Cells of probes do not
    // fit together: vertices are not shared, stats().volume_sum is no volume of the domain, and delaunay(), verify(),
    // wrapped_points() and render() refuse the result. status(): `outside` where the domain is not; `duplicate` for a
    // query at the place of a seed, which duplicate_of() names; `empty` where seeds leave it no cell. A probe on a seed
    // of less weight has its cell. Throws as locate(), and invalid_argument for weights without a power diagram.
    [[nodiscard]] Tessellation probe(std::span<const double> queries, const ProbeOptions& options = {}) const;
    // Natural-neighbor coordinates (Sibson 1980) of queries, as for locate(). Throws as locate(); invalid_argument for
    // gradients of Laplace's; `unsupported` where a periodic box has so few seeds that a cell meets its own image. The
    // first call with half as many queries as seeds or more, of Sibson's in a box, keeps all Voronoi vertices from then
    // on: 430 bytes a seed, while they are found 1.2 KB, and answers two to three times faster.
    [[nodiscard]] NaturalCoordinates natural_neighbors(std::span<const double> queries,
                                                       const NaturalOptions& options = {}) const;
    // The sums of the seeds' values, (N, m) with m = components, by these coordinates. Throws as natural_neighbors(),
    // and invalid_argument for values of another shape.
    [[nodiscard]] Interpolated interpolate(std::span<const double> values, std::size_t components,
                                           std::span<const double> queries, const NaturalOptions& options = {}) const;
    // What the seeds carry, on a grid. values: (N, m), row i of seed i; what is NaN or infinite makes so what it
    // reaches, and rows of seeds without a cell, but for duplicates in `dtfe`, count for nothing. grid becomes (nx, ny,
    // nz, m) in C order, in the unit of values; for `dtfe` per unit of volume. Digits do not depend on the threads, but
    // for the last ones of `sibson`.
    // `mean` and `dtfe` build all cells with their faces first, 1.2 KB a seed meanwhile. Returns the number of seeds
    // whose mass `dtfe` could not place, 0 for the other methods. Throws invalid_argument for arrays or options that do
    // not fit; as tessellate(), and with `nearest` and `sibson` as locate() and interpolate().
    std::size_t to_grid(std::span<const double> values, const GridOptions& options, std::span<double> grid) const;

private:
    std::shared_ptr<detail::DiagramState> state_;
};

}  // namespace votess

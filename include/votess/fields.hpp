// Fields on regular grids: what the seeds carry, averaged over the cells of a grid that covers the domain.
//
// Grid cells divide the box of a result, Tessellation::box(), along x, y and z, and a triclinic box along its edges a,
// b and c. Grid cell (i, j, k) is element (i * ny + j) * nz + k of an array of the shape (nx, ny, nz).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "votess/votess.hpp"

namespace votess {

enum class GridMethod : std::int32_t {
    // The field that is values[i] in the cell of seed i, averaged over the volume of each grid cell: cells are cut by
    // the grid, nothing is sampled. Where the domain is not, beyond walls, the field is 0: a grid cell that walls cut
    // holds the part inside, and of values that are 1 the share of its volume that lies inside. So the grid times the
    // volume of a grid cell sums to that of values times volumes, to a relative 1e-12 of their magnitudes. Needs
    // Want::faces, without min_face and min_area.
    mean = 0,
    // The Delaunay tessellation field estimator (Schaap, van de Weygaert: Continuous fields and density reconstruction,
    // A&A 363, 2000). values are masses. The density at seed i is 4 values[i] / W, where W is the volume of the
    // tetrahedra of delaunay() around it; it is linear in each of them, and 0 outside of all. A polytope is cut into
    // tetrahedra from its center, and its facets from theirs, where the density is the mean of that at the corners: so
    // the order of the seeds does not matter, and W becomes four times the integral of what is 1 at the seed and 0 at
    // the others. The average over a grid cell is exact: the grid times the volume of a grid cell sums to all mass, to
    // a relative 1e-12. Duplicates add their mass to the seed that has the cell. A seed in no tetrahedron has no
    // density: one that was dropped, that has no cell, or that lies at the rim of a domain that is not periodic, where
    // delaunay() lacks simplices. to_grid() counts them. Needs Want::faces, without min_face and min_area.
    dtfe = 1,
    // values[i] of the cell that holds the center of the grid cell, as Diagram::locate() says; 0 outside of the domain.
    nearest = 2,
};

struct GridOptions {
    std::array<std::size_t, 3> shape{};  // nx, ny, nz: 1 to 2^20 each
    GridMethod method = GridMethod::mean;
    std::size_t columns = 1;  // m, numbers that each seed has
    // 0, 1 or 2: sum along this axis or edge, times the length of a grid cell along it. That makes densities column
    // densities, of a grid whose shape is 1 there. `mean` and `dtfe` integrate exactly, whatever the shape was.
    std::optional<int> project = std::nullopt;
    unsigned threads = 0;  // 0 = all; at most 1024. The result does not depend on it.
};

// points: 3N, the array given to tessellate(). values: (N, m), row i of seed i; what is NaN or infinite makes so what
// it reaches, and rows of seeds without a cell, but for duplicates in `dtfe`, count for nothing. grid becomes (nx, ny,
// nz, m) in C order, in the unit of values; for `dtfe` per unit of volume. Returns the number of seeds whose mass
// `dtfe` could not place, 0 for the other methods. Throws Error: invalid_argument, out_of_memory, and of `nearest` what
// Diagram::locate() throws.
VOTESS_API std::size_t to_grid(const Tessellation& tessellation, std::span<const double> points,
                               std::span<const double> values, const GridOptions& options, std::span<double> grid);

}  // namespace votess

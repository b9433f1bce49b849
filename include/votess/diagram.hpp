// Seeds that stay, asked many times: which cell holds a point; what cell a point would have.
#pragma once

#include <cstdint>
#include <memory>
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
};

// Sibson's: the share of a query's cell that each neighbor had before. Laplace's: the area of the face with a neighbor
// over its distance, over the sum of these. Both reproduce linear fields away from the walls; Sibson's are smooth but
// at the seeds.
enum class NaturalMethod : std::int32_t { sibson = 0, laplace = 1 };

struct NaturalOptions {
    NaturalMethod method = NaturalMethod::sibson;
    // Cells end at walls, as if the seeds had mirror images behind, with their values: weights still sum to 1, but
    // linear fields are not reproduced where the cell of a query has a wall. False: there are no coordinates there.
    bool at_walls = true;
    bool gradients = false;           // Sibson's only
    std::span<const double> weights;  // Q, of the queries in a power diagram; empty: 0
};
// Row q, from indptr[q] on: the natural neighbors of query q, ascending, and their weights, which are positive and sum
// to 1 within 1e-13. A query on a seed has that one alone. Rows are empty outside of the domain, where there are no
// seeds, where a cell has a wall unless at_walls, and where seeds of a power diagram leave a query no cell.
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

// Seeds, sorted and searched once; no cell is built. A shared handle to what never changes, cheap to copy: any number
// of threads may ask one at the same time. Queries run on the CPU, on options.threads threads, one call after the
// other.
class VOTESS_API Diagram {
public:
    Diagram();  // of no seeds
    // points: as for tessellate(); copied. Of the options those of the domain, weights, radii, outside, duplicates,
    // threads, grid_resolution and instructions count. Throws Error as tessellate() does; `unsupported` for a device
    // other than "cpu" and "auto"; invalid_argument with min_face or min_area, for the cells are whole.
    explicit Diagram(std::span<const double> points, const Options& options = {});

    [[nodiscard]] std::size_t size() const noexcept;  // number of seeds, N
    // queries: 3Q coordinates, finite; in a periodic domain anywhere, they are wrapped without rounding. Returns Q
    // seeds: the one whose cell holds the query, so that |x - p|^2 - w is least, exactly; of several on a face, edge or
    // vertex the lowest; -1 outside of the domain, and where there are no seeds. On a wall is inside. Of seeds at one
    // place the one that has the cell is named, see Options::duplicates. Throws invalid_argument, and `unsupported` for
    // a query too small beside the box to be represented at one scale.
    [[nodiscard]] std::vector<std::int32_t> locate(std::span<const double> queries) const;
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

private:
    std::shared_ptr<detail::DiagramState> state_;
};

}  // namespace votess

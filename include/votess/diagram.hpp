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

private:
    std::shared_ptr<detail::DiagramState> state_;
};

}  // namespace votess

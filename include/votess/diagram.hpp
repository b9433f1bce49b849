// Seeds that stay, asked many times: which cell holds a point.
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

private:
    std::shared_ptr<detail::DiagramState> state_;
};

}  // namespace votess
